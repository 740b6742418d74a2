"""The URDF file that a name, a path or a ``package://`` path means."""

import os
from collections.abc import Sequence
from pathlib import Path

from ftcfa.checks import known_name
from ftcfa.errors import ParameterError, UrdfError
from ftcfa.model.urdf.catalogue import CatalogueEntry, catalogue


def locate(
    robot: str | os.PathLike[str], package_dirs: Sequence[str | os.PathLike[str]]
) -> tuple[CatalogueEntry | None, Path]:
    """Entry of the catalogue (None for a file of the user) and path of the URDF; see `load_arm`."""
    expected = "a name or the path of a URDF"
    if not isinstance(robot, (str, os.PathLike)):
        raise ParameterError("robot", repr(robot), expected, field="robot")
    text = os.fspath(robot)
    if text.startswith("package://"):
        return None, _find_in_packages(text, package_dirs)
    if isinstance(robot, str) and robot in catalogue():
        entry = catalogue()[robot]
        return entry, entry.path()
    if text.lstrip().startswith("<"):
        remedy = "write the text to a file"
        raise ParameterError("robot", "XML text", expected, remedy, field="robot")
    path = Path(text)
    exists = os.path.exists(path)  # noqa: PTH110 (pathlib's raises where a name is too long)
    if isinstance(robot, str) and len(path.parts) == 1 and not path.suffix and not exists:
        subject = "robot (not a file, not an arm of the catalogue)"
        known_name(subject, robot, catalogue(), field="robot")
    return None, path


def _find_in_packages(uri: str, package_dirs: Sequence[str | os.PathLike[str]]) -> Path:
    package, _, inside = uri.removeprefix("package://").partition("/")
    from_ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    if isinstance(package_dirs, (str, os.PathLike)):
        package_dirs = [package_dirs]
    folders = [Path(folder).resolve() for folder in (*package_dirs, *from_ros) if folder]
    for folder in folders:
        for root in (folder / package, *([folder] if folder.name == package else [])):
            if (root / inside).is_file():
                return root / inside
    searched = ", ".join(map(str, folders)) or "no folder"
    raise UrdfError(
        uri,
        f"not found (searched: {searched})",
        f"a folder that holds the package '{package}'",
        "name it in package_dirs or in the environment variable ROS_PACKAGE_PATH",
        field="robot",
    )
