"""Write files whole or not at all; read no file that is larger than memory."""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from ftcfa.errors import FtcfaError, ParameterError

MAX_TOML = 16 * 2**20
"""Largest TOML file that is read [bytes]."""
MAX_BYTES = 2**30
"""Largest file of numbers that is read [bytes]."""


def local_path(path: str | os.PathLike[str]) -> Path:
    """A path that a user gave, with ~ as the home folder; the one place where this is done.

    Raises:
        ParameterError: If it is a URL, or names an unknown user.
    """
    text = os.fspath(path)
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:/", text):  # Path makes one slash of two
        remedy = "copy it here first, or mount it as a folder"
        raise ParameterError(text, "a URL", "a path of this machine", remedy)
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise ParameterError(text, str(error), "a path of this machine") from error


def read_bounded(path: Path, most: int = MAX_BYTES) -> bytes:
    """Content of a file of at most so many bytes.

    Raises:
        ParameterError: If it cannot be read, or is larger.
    """
    try:
        with local_path(path).open("rb") as stream:
            content = stream.read(most + 1)
    except (OSError, ValueError) as error:  # ValueError: a null byte
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        remedy = "check the path and its permissions"
        raise ParameterError(str(path), reason, "a readable file", remedy) from error
    if len(content) > most:
        size = f"{most / 2**20:g} MiB"
        raise ParameterError(str(path), f"more than {size}", f"a file of at most {size}")
    return content


def decoded(content: bytes) -> tuple[str, int | None]:
    """Text of a file, and the place of the first byte for which it is read as Latin-1, or None.

    UTF-16 by its mark, UTF-8, else Latin-1, where every byte is a letter.
    """
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace"), None
    try:
        return content.decode("utf-8-sig"), None
    except UnicodeDecodeError as error:
        return content.decode("latin-1"), error.start


def read_toml(path: Path) -> dict[str, Any]:
    """The document of a TOML file.

    Raises:
        ParameterError: If it cannot be read, is too large or is no TOML.
    """
    content = read_bounded(path, MAX_TOML)
    try:
        return tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # TOML, UTF-8, numbers of 5,000 digits, nesting
        raise ParameterError(str(path), str(error), "a TOML file") from error


def make_folder(folder: Path) -> None:
    """Make a folder and its parents, and make sure that files can be written there.

    Raises:
        FtcfaError: If it cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
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


def _refused(path: Path, error: OSError | ValueError) -> FtcfaError:
    """The error for a file or folder that cannot be written."""
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    return FtcfaError(str(path), f"cannot be written ({reason})", "", "choose another folder")
