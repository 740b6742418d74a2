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
EFFORT = "Effort limit of every joint, in N m or N. Overrides the URDF."
PACKAGES = (
    "Folder in which packages of package:// paths are searched; repeatable. "
    "Without it: ROS_PACKAGE_PATH."
)


def inspect(
    robot: Annotated[str | None, typer.Argument(metavar="ROBOT", help=ROBOT)] = None,
    lock: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help=LOCK)] = None,
    effort_limit: Annotated[float | None, typer.Option(help=EFFORT)] = None,
    gravity: Annotated[float, typer.Option(help="Acceleration of gravity, in m/s^2.")] = 9.81,
    package_dir: Annotated[list[str] | None, typer.Option(metavar="DIR", help=PACKAGES)] = None,
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
        robot, lock=_locks(lock or []), effort_limit=effort_limit, gravity=gravity,
        package_dirs=package_dir or (),
    )  # fmt: skip
    show = partial(print_arm, description=descriptions.get(robot, ""))
    finish(arm_record(arm), show, as_json)


def _locks(words: Sequence[str]) -> dict[str, float]:
    """Joint values from words NAME=VALUE."""
    from ftcfa.errors import ParameterError

    locks = {}
    for word in words:
        name, _, value = word.rpartition("=")
        try:
            locks[name] = float(value)
        except ValueError:
            name = ""
        if not name:
            raise ParameterError("--lock", word, "NAME=VALUE with a number [rad or m]")
    return locks
