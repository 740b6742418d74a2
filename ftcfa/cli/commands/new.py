"""``ftcfa new``: an experiment file for any arm, which runs as it is."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, Hardware, local

ROBOT = "An arm that ftcfa knows by name (`ftcfa inspect` lists them), or the path of a URDF."
VIBRATION = "Standard of `ftcfa vibration`: once for up and down, three times for x, y and z."
TABLE = "File with a spectrum (up and down) or three (x, y, z) of one's own."
RECORD = "Record of an accelerometer with one axis (up and down) or three (x, y, z)."
ROAD = "Class of the road under a car, A to F of ISO 8608."
MOUNTING = "How the arm is mounted: floor, wall or ceiling."
OUT = "File to write. Without it: the robot's name with .toml, here."
FORCE = "Write over a file that exists."


def new(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help=ROBOT)],
    vibration: Annotated[list[str] | None, typer.Option(metavar="NAME", help=VIBRATION)] = None,
    table: Annotated[Path | None, typer.Option(metavar="FILE", help=TABLE, callback=local)] = None,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE", help=RECORD, callback=local)
    ] = None,
    road: Annotated[str | None, typer.Option(metavar="CLASS", help=ROAD)] = None,
    speed: Annotated[float | None, typer.Option(help="Speed on the road, in m/s [15].")] = None,
    mounting: Annotated[str | None, typer.Option(help=MOUNTING)] = None,
    hardware: Hardware = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help=OUT, callback=local)] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: AsJson = False,
) -> None:
    """Write an experiment for an arm that runs as it is, with every key and its meaning.

    Example: ftcfa new panda --road C --speed 20 --hardware fr3
    """
    from ftcfa.errors import ParameterError
    from ftcfa.files import make_folder
    from ftcfa.starter import Shaking, starter

    file = Path(f"{Path(robot).stem}.toml") if out is None else out
    if file.exists() and not force:
        raise ParameterError(str(file), "exists", "a new file", "give --out, or --force")
    make_folder(file.parent)
    shaking = Shaking(tuple(vibration or ()), table, record, road, speed)
    text = starter(robot, shaking, mounting=mounting, hardware=hardware, folder=file.parent)
    next_commands = [f"ftcfa {command} {file}" for command in ("run", "verify", "tune")]
    record_ = {"file": str(file), "next": next_commands}
    finish(record_, _print, as_json, {file.name: text.encode()}, file.parent)


def _print(record: Any, console: Any) -> None:
    from ftcfa.report.terminal import print_line

    print_line(f"{record['file']} is ready. Next: {', '.join(record['next'])}", console)
