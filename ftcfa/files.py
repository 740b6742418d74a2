"""Write files whole or not at all."""

import os
from pathlib import Path

from ftcfa.errors import FtcfaError


def make_folder(folder: Path) -> None:
    """Make a folder and its parents, and make sure that files can be written there.

    Raises:
        FtcfaError: If it cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refused(folder, error) from error
    probe = folder / f".writable.{os.getpid()}"
    write_whole(probe, b"")
    probe.unlink(missing_ok=True)


def write_whole(file: Path, content: bytes) -> None:
    """Write under a temporary name beside the file, then rename: never half a file.

    Raises:
        FtcfaError: If the disk is full or the file cannot be written.
    """
    temporary = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        try:
            temporary.write_bytes(content)
            temporary.replace(file)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _refused(file, error) from error


def _refused(path: Path, error: OSError) -> FtcfaError:
    """The error for a file or folder that cannot be written."""
    reason = (error.strerror or "unknown reason").lower()
    return FtcfaError(str(path), f"cannot be written ({reason})", "", "choose another folder")
