"""Expand xacro, the macro language in which ROS writes its URDFs, with the extra ``xacro``."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from ftcfa.errors import UrdfError

SECONDS = 60
"""Longest time that a file may take [s]."""
REASON = 300
"""Length to which a message shortens the reason of a failure."""


def expand(file: Path, folders: Sequence[Path], arguments: Mapping[str, str]) -> bytes:
    """The URDF that a xacro file means.

    Packages are looked for above the file, where a folder has a package.xml, and in ``folders``;
    nothing is read outside those. See `ftcfa.model.urdf.xacro_child` for what is kept from the
    file's expressions.

    Raises:
        UrdfError: If the extra is not installed, or the file cannot be expanded.
    """
    if find_spec("xacrodoc") is None:
        remedy = "run `pip install 'ftcfa[xacro]'`, or `xacro FILE > arm.urdf` first"
        raise UrdfError(str(file), "this is a xacro file", "plain URDF", remedy)
    file = file.expanduser().resolve()
    package = _package_of(file)
    asked = {
        "file": str(file),
        "folders": [str(folder) for folder in (package, *folders)],
        "packages": {name: str(path) for name, path in _packages(folders).items()},
        "arguments": {name: str(value) for name, value in arguments.items()},
    }
    command = [sys.executable, "-I", "-X", "utf8", "-m", "ftcfa.model.urdf.xacro_child"]
    try:
        done = subprocess.run(
            command, input=json.dumps(asked).encode(), capture_output=True, timeout=SECONDS,
            cwd=file.parent, env={},
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        got, expected = f"xacro did not end in {SECONDS} s", "a file that expands"
        raise UrdfError(str(file), got, expected, "look for macros without an end") from error
    if done.returncode:
        words = done.stderr.decode("utf-8", errors="replace").split("\n")
        reason = next((line for line in reversed(words) if line.strip()), "no reason given")
        got = f"cannot be expanded ({reason.strip()[:REASON]})"
        remedy = "name folders of packages with package_dirs, and arguments with xacro_args"
        raise UrdfError(str(file), got, "a xacro file", f"{remedy} (--package-dir, --arg)")
    return done.stdout


def _package_of(file: Path) -> Path:
    """The folder above a file that is a ROS package, else the file's own."""
    return next((f for f in file.parents if (f / "package.xml").is_file()), file.parent)


def _packages(folders: Sequence[Path]) -> dict[str, Path]:
    """Packages by name: the folders, and those in them; the first of a name counts."""
    found: dict[str, Path] = {}
    for folder in folders:
        inside = sorted(f for f in folder.iterdir() if f.is_dir()) if folder.is_dir() else []
        for path in (folder, *inside):
            found.setdefault(path.name, path)
    return found
