"""``ftcfa inspect``: show an arm."""

from collections.abc import Sequence
from functools import partial
from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson

ROBOT = "Name of an arm, or path of a URDF. Without it: list the names."
LOCK = (
    "Hold a joint at a value, in rad or m; repeatable. "
    "Without it: only the joints that the list of known arms locks."
)
EFFORT = (
    "Effort limit of every joint or, repeatable, of one by name, in N m or N. Overrides the URDF."
)
REPAIR = "Turn inertias that no body can have into the nearest ones that some body has."
ARGUMENT = "Argument of a xacro file; repeatable."
PACKAGES = (
    "Folder in which packages of package:// paths are searched; repeatable. "
    "Without it: ROS_PACKAGE_PATH."
)


def inspect(
    robot: Annotated[str | None, typer.Argument(metavar="ROBOT", help=ROBOT)] = None,
    lock: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help=LOCK)] = None,
    effort_limit: Annotated[
        list[str] | None, typer.Option(metavar="[NAME=]VALUE", help=EFFORT)
    ] = None,
    gravity: Annotated[float, typer.Option(help="Acceleration of gravity, in m/s^2.")] = 9.81,
    package_dir: Annotated[list[str] | None, typer.Option(metavar="DIR", help=PACKAGES)] = None,
    repair: Annotated[bool, typer.Option("--repair", help=REPAIR)] = False,
    arg: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help=ARGUMENT)] = None,
    as_json: AsJson = False,
) -> None:
    """Show an arm: joints, limits, friction, mass, bounds of its mass matrix, warnings.

    Example: ftcfa inspect panda --lock panda_joint1=0.5
    """
    from ftcfa.model.urdf.catalogue import catalogue
    from ftcfa.model.urdf.load import load_arm
    from ftcfa.report.arm import arm_record, print_arm, print_catalogue

    descriptions = {name: entry.description for name, entry in catalogue().items()}
    if robot is None:
        finish(descriptions, print_catalogue, as_json)
        return
    arm = load_arm(
        robot, lock=_numbers("--lock", lock or []), effort_limit=_efforts(effort_limit or []),
        gravity=gravity, package_dirs=package_dir or (), repair="project" if repair else None,
        xacro_args=_texts("--arg", arg or []),
    )  # fmt: skip
    show = partial(print_arm, description=descriptions.get(robot, ""))
    finish(arm_record(arm), show, as_json)


def _texts(option: str, words: Sequence[str]) -> dict[str, str]:
    """Texts by name, of words NAME=VALUE; a text may have = in it."""
    from ftcfa.errors import ParameterError

    texts = {}
    for word in words:
        name, equals, texts[name] = word.partition("=")
        if not (name and equals):
            raise ParameterError(option, word, "NAME=VALUE")
    return texts


def _numbers(option: str, words: Sequence[str]) -> dict[str, float]:
    """Numbers by name, of words NAME=VALUE; a name may have = in it."""
    from ftcfa.errors import ParameterError

    numbers = {}
    for word in words:
        name, _, value = word.rpartition("=")
        try:
            numbers[name] = float(value)
        except ValueError:
            name = ""
        if not name:
            raise ParameterError(option, word, "NAME=VALUE with a number")
    return numbers


def _efforts(words: Sequence[str]) -> float | dict[str, float] | None:
    """Effort limits: one number for all joints, or numbers by name; None if none are given."""
    from ftcfa.errors import ParameterError

    if len(words) == 1 and "=" not in words[0]:
        try:
            return float(words[0])
        except ValueError as error:
            expected = "VALUE or NAME=VALUE with a number"
            raise ParameterError("--effort-limit", words[0], expected) from error
    return _numbers("--effort-limit", words) or None
