"""Arrays of numbers from NumPy's files, none larger than a limit, whatever the file says."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError
from ftcfa.files import MAX_BYTES, read_bounded

EXPECTED = "a NumPy array of real numbers"
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
"""Readers of an array's shape and type by the version of its format."""
MAX_HEADER = 10_000
"""Longest header of an array [bytes]."""


def read_npy(path: Path) -> tuple[Array, bool, str]:
    """Values (samples, columns), that the first column is time [s], and no unit of the others."""
    return _table(path, _array(path, read_bounded(path))), True, ""


def read_npz(path: Path) -> tuple[Array, bool, str]:
    """Values (samples, columns) of ``acceleration``, whether ``time`` [s] is first, ``unit``."""
    arrays = _members(path)
    if "acceleration" not in arrays:
        got, expected = f"arrays {sorted(arrays)}", "arrays time and acceleration"
        raise ParameterError(str(path), got, expected)
    names = ("time",) if "time" in arrays else ()
    parts = [_table(path, arrays[name]) for name in (*names, "acceleration")]
    if len({len(part) for part in parts}) > 1:
        shapes = ", ".join(str(part.shape) for part in parts)
        raise ParameterError(str(path), f"shapes {shapes}", "(samples,) and (samples, axes)")
    unit = str(arrays["unit"]) if "unit" in arrays else ""
    return np.hstack(parts), bool(names), unit


def _members(path: Path) -> dict[str, npt.NDArray[Any]]:
    """The arrays of a zip file, by name."""
    content = read_bounded(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            total = sum(member.file_size for member in archive.infolist())
            if total > MAX_BYTES:
                got = f"{total / 2**20:.0f} MiB when unpacked"
                raise ParameterError(str(path), got, f"at most {MAX_BYTES // 2**20} MiB")
            members = {m.filename.removesuffix(".npy"): archive.read(m) for m in archive.infolist()}
    except ParameterError:
        raise
    except Exception as error:  # zipfile, zlib and struct raise many kinds
        raise ParameterError(str(path), _reason(error), "a zip file of NumPy's arrays") from error
    wanted = ("time", "acceleration", "unit")
    return {name: _array(path, members[name]) for name in wanted if name in members}


def _array(path: Path, content: bytes) -> npt.NDArray[Any]:
    """The array of a file's content; no more memory than the content is taken."""
    stream = io.BytesIO(content)
    try:
        version = np.lib.format.read_magic(stream)
        shape, fortran, dtype = HEADERS[version](stream, max_header_size=MAX_HEADER)
        if dtype.hasobject:
            raise ValueError("it holds Python objects, not numbers")
        flat = np.frombuffer(content, dtype, offset=stream.tell())
        return flat.reshape(shape, order="F" if fortran else "C")
    except Exception as error:  # NumPy evaluates the header as a Python literal
        raise ParameterError(str(path), _reason(error), EXPECTED) from error


def _table(path: Path, values: npt.NDArray[Any]) -> Array:
    """Real numbers as (samples, columns)."""
    if values.dtype.kind not in "fiu":
        raise ParameterError(str(path), f"an array of {values.dtype}", "real numbers")
    table = values[:, None] if values.ndim == 1 else values
    if table.ndim != 2 or table.size == 0:
        raise ParameterError(str(path), f"shape {values.shape}", "(samples, columns)")
    return table.astype(float)


def _reason(error: Exception) -> str:
    return f"unreadable ({str(error) or type(error).__name__})"
