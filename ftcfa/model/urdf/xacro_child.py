"""A process of its own that expands a xacro file: ``python -I -m ftcfa.model.urdf.xacro_child``.

xacro evaluates the file's expressions as Python. This process therefore reads only below the given
folders, writes nothing, has no environment, and is stopped by its parent if it takes too long. Its
standard input is a JSON object with file, folders, packages and arguments; its standard output the
URDF.
"""

import errno
import json
import os
import resource
import sys
from pathlib import Path
from typing import Any

from xacrodoc import XacroDoc, packages

MEMORY = 4 * 2**30
"""Largest address space of the process [bytes]."""
FORBIDDEN = (
    "subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.remove", "os.rename",
    "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.chmod", "os.chown", "os.truncate",
    "os.putenv", "shutil.", "socket.", "ctypes.", "urllib.", "ftplib.", "http.",
)  # fmt: skip
"""Starts of the audit events (sys.addaudithook) that expanding never needs."""


def confine(folders: list[Path]) -> None:
    """Refuse, for the rest of the process, all files but those below folders and Python's own."""
    readable = [*folders, *(Path(sys.base_prefix), Path(sys.prefix)), *map(Path, sys.path)]

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event.startswith(FORBIDDEN):
            raise PermissionError(f"xacro must not use {event}")
        if event != "open" or not isinstance(arguments[0], str | bytes):
            return
        path, flags = Path(os.fsdecode(arguments[0])).resolve(), arguments[2]
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND):
            raise PermissionError(errno.EACCES, "xacro must not write it", str(path))
        if not any(path.is_relative_to(folder) for folder in readable):
            where = "outside the file's package and package_dirs"
            raise PermissionError(errno.EACCES, where, str(path))

    sys.addaudithook(watch)


def main() -> None:
    """Expand the file that standard input names; standard error says why it cannot be."""
    try:
        sys.stdout.write(expanded())
    except Exception as error:  # whatever the file's expressions raise
        said = (str(one) for one in (getattr(error, "exc", None), error) if one is not None)
        sys.exit(" ".join((min(said, key=len) or type(error).__name__).split()))


def expanded() -> str:
    """The URDF of the file that standard input names."""
    asked = json.load(sys.stdin)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    packages.update_package_cache(asked["packages"])
    confine([Path(folder) for folder in asked["folders"]])
    document = XacroDoc.from_file(asked["file"], subargs=asked["arguments"], resolve_packages=False)
    return str(document.to_urdf_string())


if __name__ == "__main__":
    main()
