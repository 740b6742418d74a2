"""Chunks of an ensemble on disk: written whole or not at all, found again after any interruption.

    STORE/.zattrs              what was run: attributes ``identity`` and ``ftcfa_version``
    STORE/chunks/000007/       a chunk's Dataset
    STORE/result/              the summary, once there is one

The folder is a hierarchy of zarr groups, each readable by xarray alone, such as
``xarray.open_zarr(STORE, group="result")``. A group is written under another name beside its
place and then renamed, so that nothing half-written ever bears its name. One process writes at a
time: it holds a lock that the system takes from it when it ends, however it ends.
"""

import fcntl
import json
import os
import shutil
import warnings
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from glob import escape
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO, Final, Self
from uuid import uuid4

import numpy as np
import xarray as xr
import zarr

from ftcfa.description.write import differences
from ftcfa.errors import FtcfaError, ParameterError

CHUNKS, RESULT, GROUP = "chunks", "result", ".zgroup"
UNFINISHED = ".part"
HEX = 32 * "[0-9a-f]"
CHECKSUM = "checksum"
ZARR_FORMAT: Final = 2
"""Version 3 has no stable type for texts of joints' names."""


class Store:
    """A folder of chunks, for one process to write to; as a context it is given free at the end.

    Args:
        path: The folder; made if it is not there or empty.
        identity: What the chunks are of, as plain data.

    Raises:
        ParameterError: If the folder is of something else.
        FtcfaError: If it cannot be written, or another process writes to it.
    """

    def __init__(self, path: str | os.PathLike[str], identity: Mapping[str, Any]) -> None:
        self.path = Path(path)
        told = json.dumps(identity, sort_keys=True)
        if not self.path.exists() or _is_empty(self.path):
            self._make(told)
        self._check(told)
        self._lock = self._locked()
        self._tidy()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def _make(self, told: str) -> None:
        """Have the folder made, unless another process is faster."""
        with self._writing(), _unfinished(self.path) as place:
            try:
                _root(place, told)
                place.rename(self.path)
            except OSError:
                if not (self.path / GROUP).exists():
                    raise

    def _check(self, told: str) -> None:
        try:
            found = zarr.open_group(self.path, mode="r").attrs.get("identity")
        except (OSError, ValueError, zarr.errors.GroupNotFoundError) as error:
            raise ParameterError(
                str(self.path), "no store of an ensemble", "a new folder, or one that ensemble made"
            ) from error
        if found != told:
            differ = differences(json.loads(str(found)), json.loads(told)) if found else "all"
            raise self.of_another(f"they differ in {differ}")

    def of_another(self, reason: str) -> ParameterError:
        """The error of a store that is of another experiment."""
        return ParameterError(
            str(self.path),
            f"a store of another experiment ({reason})",
            "the one that was begun",
            "choose another folder, or run the same experiment",
        )

    def _locked(self) -> BinaryIO:
        """The right to write, held until the file is closed."""
        with self._writing():
            file = (self.path / GROUP).open("r+b")
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                file.close()
                raise FtcfaError(
                    str(self.path),
                    "another process is writing to it",
                    "",
                    "wait until it has ended, or choose another folder",
                ) from error
        return file

    def _tidy(self) -> None:
        """Remove what other processes left unfinished: none of them writes while this one does."""
        beside = self.path.parent.glob(f"{escape(self.path.name)}.{HEX}{UNFINISHED}")
        for place in (*beside, *self.path.rglob(f"*{UNFINISHED}")):
            shutil.rmtree(place, ignore_errors=True)

    def read(self, chunk: int) -> xr.Dataset | None:
        """A chunk, or None if it is not there; of a damaged one a warning tells.

        Damaged is what cannot be read or has another checksum than what was written.
        """
        place = self._place(chunk)
        if not place.exists():
            return None
        try:
            with xr.open_zarr(place, consolidated=False, chunks=None) as dataset:
                dataset.load()
        except Exception:  # what a damaged file raises, no library says
            dataset = xr.Dataset()
        if dataset.attrs.pop(CHECKSUM, None) == _checksum(dataset):
            return dataset
        warnings.warn(f"{place}: damaged; its paths are run again", stacklevel=2)
        return None

    def write(self, chunk: int, dataset: xr.Dataset) -> None:
        """Write a chunk, in place of the one that may be there.

        Raises:
            FtcfaError: If it cannot be written; what is there stays.
        """
        self._put(self._place(chunk), dataset.assign_attrs({CHECKSUM: _checksum(dataset)}))

    def write_result(self, dataset: xr.Dataset) -> None:
        """Write the summary, in place of the one that may be there.

        Raises:
            FtcfaError: If it cannot be written.
        """
        self._put(self.path / RESULT, dataset)

    def _place(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}"

    def _put(self, place: Path, dataset: xr.Dataset) -> None:
        with self._writing(), _unfinished(place) as unfinished:
            dataset.to_zarr(unfinished, mode="w", consolidated=False, zarr_format=ZARR_FORMAT)
            _rename(unfinished, place)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """One sentence for whatever keeps us from writing."""
        try:
            yield
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise FtcfaError(
                str(self.path),
                f"cannot be written ({reason})",
                "",
                "what is there is whole: mend that and run again to go on",
            ) from error


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and next(folder.iterdir(), None) is None


def _root(place: Path, told: str) -> None:
    attributes = {"identity": told, "ftcfa_version": version("ftcfa")}
    group = zarr.create_group(place, zarr_format=ZARR_FORMAT, attributes=attributes)
    group.create_group(CHUNKS)


@contextmanager
def _unfinished(place: Path) -> Iterator[Path]:
    """A folder beside a place; if it still has that name at the end, it is removed."""
    unfinished = place.with_name(f"{place.name}.{uuid4().hex}{UNFINISHED}")
    try:
        unfinished.parent.mkdir(parents=True, exist_ok=True)
        yield unfinished
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _rename(new: Path, place: Path) -> None:
    """Give a folder its name, taking it from the one that bears it."""
    if place.exists():
        old = place.with_name(f"{place.name}.old{UNFINISHED}")
        place.rename(old)
        new.rename(place)
        shutil.rmtree(old, ignore_errors=True)
    else:
        new.rename(place)


def _checksum(dataset: xr.Dataset) -> int:
    """Of all names, shapes and numbers; any NaN is like any other."""
    total = 0
    for name, rows in sorted(dataset.variables.items(), key=lambda item: str(item[0])):
        values = rows.values
        if np.issubdtype(values.dtype, np.floating):
            values = np.where(np.isnan(values), np.nan, values)
        total = zlib.crc32(f"{name} {values.dtype} {values.shape}".encode(), total)
        total = zlib.crc32(values.tobytes(), total)
    return total
