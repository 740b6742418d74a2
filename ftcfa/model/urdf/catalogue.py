"""Arms by name, as `robots/catalogue.toml` lists them."""

import importlib.metadata
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from ftcfa.errors import UrdfError

_PACKAGE = Path(__file__).parents[2]
_DATA_PACKAGE = "example-robot-data"
_DATA_ROOT = "share/example-robot-data/robots"


@dataclass(frozen=True)
class CatalogueEntry:
    """One arm of the catalogue.

    Attributes:
        description: The arm in a phrase.
        file: Path of the URDF in `robots/` or, with ``package``, in example-robot-data's robots.
        package: Whether the file comes from example-robot-data.
        joints: Joints that move; empty means all. The others are locked at their home position.
        home: Home positions of moving and locked joints [rad or m]; see `home_position` for
            joints that are not listed.
    """

    description: str
    file: str
    package: bool = False
    joints: tuple[str, ...] = ()
    home: Mapping[str, float] = field(default_factory=dict)

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
        raise UrdfError(
            _DATA_PACKAGE, "not installed", "its URDFs", f"run `pip install {_DATA_PACKAGE}`"
        ) from error
    for file in files:
        path = file.as_posix()
        if f"{_DATA_ROOT}/" in path:
            inside = path.split(f"{_DATA_ROOT}/", 1)[1]
            return Path(str(file.locate())).parents[inside.count("/")].resolve()
    raise UrdfError(_DATA_PACKAGE, "holds no robots", f"files below {_DATA_ROOT}", "reinstall it")
