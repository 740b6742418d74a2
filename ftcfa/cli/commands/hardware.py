"""``ftcfa hardware``: show the hardware profiles of real robots."""

from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson

NAMES = "Names of profiles. Without any: show all."


def hardware(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[PROFILE]...", help=NAMES, show_default=False)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show profiles of robots' hardware and classes of accelerometers, with every source.

    Example: ftcfa hardware fr3
    """
    from ftcfa.checks import known_name
    from ftcfa.hardware.profiles import accelerometers, profiles
    from ftcfa.report.hardware import print_profiles, profiles_record

    known = {**profiles(), **accelerometers()}
    for name in names or []:
        known_name("hardware profile", name, known)
    chosen = {name: known[name] for name in names or known}
    finish(profiles_record(chosen), print_profiles, as_json)
