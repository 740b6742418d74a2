"""The URDF that a name, a path or a ``package://`` path means; the arms with a name."""

import importlib.metadata
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from ftcfa.checks import known_name
from ftcfa.errors import ParameterError, UrdfError

_PACKAGE = Path(__file__).parents[2]
_DATA_PACKAGE = "example-robot-data"
_DATA_ROOT = "share/example-robot-data/robots"


@dataclass(frozen=True)
class CatalogueEntry:
    """One arm of `robots/catalogue.toml`."""

    description: str  # the arm in a phrase
    file: str  # path of the URDF in `robots/` or, with ``package``, in example-robot-data's robots
    package: bool = False
    joints: tuple[str, ...] = ()  # joints that move, empty: all; the others are locked at home
    home: Mapping[str, float] = field(default_factory=dict)  # of any joint [rad or m]
    armature: Mapping[str, float] = field(default_factory=dict)  # J r^2 of rotors [kg m^2 or kg]

    def path(self) -> Path:
        """Path of the URDF on this machine."""
        return (_example_robots() if self.package else robots_folder()) / self.file


def robots_folder() -> Path:
    """Folder of the URDFs that we ship: in the installed package, or beside it in a checkout."""
    inside = _PACKAGE / "robots"
    return inside if inside.is_dir() else _PACKAGE.parent / "robots"


@cache
def catalogue() -> Mapping[str, CatalogueEntry]:
    """All named arms."""
    tables = tomllib.loads((robots_folder() / "catalogue.toml").read_text())
    return {
        name: CatalogueEntry(**{**table, "joints": tuple(table.get("joints", ()))})
        for name, table in tables.items()
    }


@cache
def _example_robots() -> Path:
    try:
        files = importlib.metadata.files(_DATA_PACKAGE) or ()
    except importlib.metadata.PackageNotFoundError as error:
        remedy = f"run `pip install {_DATA_PACKAGE}`"
        raise UrdfError(_DATA_PACKAGE, "not installed", "its URDFs", remedy) from error
    for file in files:
        path = file.as_posix()
        if f"{_DATA_ROOT}/" in path:
            inside = path.split(f"{_DATA_ROOT}/", 1)[1]
            return Path(str(file.locate())).parents[inside.count("/")].resolve()
    raise UrdfError(_DATA_PACKAGE, "holds no robots", f"files below {_DATA_ROOT}", "reinstall it")


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


def package_folders(package_dirs: Sequence[str | os.PathLike[str]]) -> list[Path]:
    """The folders in which packages are looked for: those given, then ROS_PACKAGE_PATH's."""
    from_ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    if isinstance(package_dirs, (str, os.PathLike)):
        package_dirs = [package_dirs]
    folders = (Path(folder).expanduser() for folder in (*package_dirs, *from_ros) if folder)
    return [folder.resolve() for folder in folders]


def _find_in_packages(uri: str, package_dirs: Sequence[str | os.PathLike[str]]) -> Path:
    package, _, inside = uri.removeprefix("package://").partition("/")
    folders = package_folders(package_dirs)
    for folder in folders:
        for root in (folder / package, *([folder] if folder.name == package else [])):
            if (root / inside).is_file():
                return root / inside
    searched = ", ".join(map(str, folders)) or "no folder"
    got = f"not found (searched: {searched})"
    expected = f"a folder that holds the package '{package}'"
    remedy = "name it in package_dirs or in the environment variable ROS_PACKAGE_PATH"
    raise UrdfError(uri, got, expected, remedy, field="robot")
