"""Chunks of an ensemble on disk, each written whole or not at all.

    STORE/.zattrs              attributes ``identity``, the experiment, and ``ftcfa_version``
    STORE/chunks/000007/       Dataset of a chunk
    STORE/result/              summary of the ensemble, once it was computed

The folder is a hierarchy of zarr groups. xarray reads each of them, for example with
``xarray.open_zarr(STORE, group="result")``. A group is written under a temporary name beside its
place and then renamed, so a group with its own name is always whole. One process writes at a time:
it holds a lock that the operating system releases whenever the process ends.
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
from pathlib import Path
from typing import Any, BinaryIO, Final, Self
from uuid import uuid4

import numpy as np
import xarray as xr
import zarr

from ftcfa.description.write import differences
from ftcfa.engine.dataset import versions
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.files import local_path

CHUNKS, RESULT, GROUP = "chunks", "result", ".zgroup"
UNFINISHED = ".part"
HEX = 32 * "[0-9a-f]"
CHECKSUM = "checksum"
OF_MACHINE = ("kernels", "probe")
"""What differs where the same experiment comes out with other last bits."""
ZARR_FORMAT: Final = 2
"""Version of the format; version 3 has no stable type for texts, such as joint names."""


def discard(path: Path) -> None:
    """Remove a store with all its chunks; nothing if there is none.

    Raises:
        ParameterError: If the folder is no store.
        FtcfaError: If another process writes to it.
    """
    if path.exists():
        _identity(path)
        with _locked(path):
            shutil.rmtree(path)


def _identity(path: Path) -> tuple[str, dict[str, Any]]:
    """The identity of a store, as it is stored and as data.

    Raises:
        ParameterError: If the folder is no store.
    """
    try:
        stored = str(zarr.open_group(path, mode="r").attrs.get("identity") or "{}")
        data = json.loads(stored)
        if not isinstance(data, dict):
            raise ValueError("its identity is damaged")
    except Exception as error:  # damaged attributes may raise anything
        raise ParameterError(
            str(path), "no store of an ensemble", "a new folder, or one that ensemble made"
        ) from error
    return stored, data


def _locked(path: Path) -> BinaryIO:
    """The lock of a store, held until the file is closed."""
    file = (path / GROUP).open("r+b")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        file.close()
        remedy = "wait until that process has ended, or choose another folder"
        raise FtcfaError(str(path), "another process is writing to it", remedy=remedy) from error
    return file


class Store:
    """A folder of chunks that one process writes to; leaving its context releases the lock.

    Args:
        path: The folder; it is made if it does not exist.
        identity: Plain data that identifies the experiment.

    Raises:
        ParameterError: If the folder holds something else or another experiment.
        FtcfaError: If it cannot be written, or another process writes to it.
    """

    def __init__(self, path: str | os.PathLike[str], identity: Mapping[str, Any]) -> None:
        self.path = local_path(path)
        text = json.dumps(identity, sort_keys=True)
        if not self.path.exists() or _is_empty(self.path):
            self._make(text)
        self._check(text)
        with self._writing():
            self._lock = _locked(self.path)
        self._tidy()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def _make(self, identity: str) -> None:
        """Make the folder, unless another process has made it meanwhile."""
        with self._writing(), _unfinished(self.path) as place:
            try:
                _root(place, identity)
                place.rename(self.path)
            except OSError:
                if not (self.path / GROUP).exists():
                    raise

    def _check(self, identity: str) -> None:
        """Raise ParameterError unless the folder is the store of an experiment."""
        stored, theirs = _identity(self.path)
        ours = json.loads(identity)
        if stored != identity:
            if differ := differences(_described(theirs), _described(ours)):
                raise self.other_experiment(f"they differ in {differ}")
            bits = differences(theirs, ours)
            got = f"a store whose paths come out with other bits (another {bits})"
            expected = "the store of this experiment, on a machine with the same bits"
            remedy = "a part of your own has other numbers, or go on where the store was begun"
            raise ParameterError(str(self.path), got, expected, remedy)

    def other_experiment(self, reason: str) -> ParameterError:
        """The error to raise where the store holds another experiment."""
        got = f"a store of another experiment ({reason})"
        remedy = "choose another folder, or discard it (ftcfa run --fresh)"
        return ParameterError(str(self.path), got, "the store of this experiment", remedy)

    def _tidy(self) -> None:
        """Remove the unfinished folders of other processes: this one holds the lock."""
        beside = self.path.parent.glob(f"{escape(self.path.name)}.{HEX}{UNFINISHED}")
        for place in (*beside, *self.path.rglob(f"*{UNFINISHED}")):
            shutil.rmtree(place, ignore_errors=True)

    def numbers(self) -> set[int]:
        """Numbers of the chunks that are there."""
        places = (self.path / CHUNKS).glob("*")
        return {int(place.name) for place in places if place.name.isdecimal()}

    def read(self, chunk: int) -> xr.Dataset | None:
        """The Dataset of a chunk, or None if there is none.

        A chunk that cannot be read, has the wrong checksum or belongs elsewhere is damaged: it
        gives a warning and None.
        """
        place = self._place(chunk)
        if not place.exists():
            return None
        try:
            with xr.open_zarr(place, consolidated=False, chunks=None) as dataset:
                dataset.load()
        except Exception:  # a damaged file may raise anything
            dataset = xr.Dataset()
        if dataset.attrs.pop(CHECKSUM, None) == _checksum(dataset, chunk):
            return dataset
        warnings.warn(f"{place}: damaged; its paths are run again", stacklevel=2)
        return None

    def write(self, chunk: int, dataset: xr.Dataset) -> None:
        """Write a chunk; one of the same number is replaced.

        Raises:
            FtcfaError: If it cannot be written; the store stays as it is.
        """
        self._put(self._place(chunk), dataset.assign_attrs({CHECKSUM: _checksum(dataset, chunk)}))

    def write_result(self, dataset: xr.Dataset) -> None:
        """Write the summary; an older one is replaced.

        Raises:
            FtcfaError: If it cannot be written.
        """
        self._put(self.path / RESULT, dataset)

    def _place(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}"

    def _put(self, place: Path, dataset: xr.Dataset) -> None:
        self._check_there()
        try:
            with self._writing(), _unfinished(place) as unfinished:
                dataset.to_zarr(unfinished, mode="w", consolidated=False, zarr_format=ZARR_FORMAT)
                _rename(unfinished, place)
        finally:
            self._check_there()  # also where it was deleted meanwhile

    def _check_there(self) -> None:
        """Raise FtcfaError if the store was deleted since it was opened."""
        if os.fstat(self._lock.fileno()).st_nlink == 0:
            got, remedy = "was deleted during the run", "run again, to a folder that stays"
            raise FtcfaError(str(self.path), got, remedy=remedy)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn an OSError of writing into an FtcfaError."""
        try:
            yield
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            got = f"cannot be written ({reason})"
            remedy = "the stored chunks are whole: remove the cause and run again to go on"
            raise FtcfaError(str(self.path), got, remedy=remedy) from error


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and next(folder.iterdir(), None) is None


def _described(identity: dict[str, Any]) -> dict[str, Any]:
    """What identifies an experiment on any machine."""
    return {name: value for name, value in identity.items() if name not in OF_MACHINE}


def _root(place: Path, identity: str) -> None:
    attributes = {"identity": identity, **versions()}
    group = zarr.create_group(place, zarr_format=ZARR_FORMAT, attributes=attributes)
    group.create_group(CHUNKS)


@contextmanager
def _unfinished(place: Path) -> Iterator[Path]:
    """A temporary folder beside a place, removed at the end unless it was renamed."""
    unfinished = place.with_name(f"{place.name}.{uuid4().hex}{UNFINISHED}")
    try:
        unfinished.parent.mkdir(parents=True, exist_ok=True)
        yield unfinished
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _rename(new: Path, place: Path) -> None:
    """Rename a folder to its place; a folder that is there is removed."""
    if place.exists():
        old = place.with_name(f"{place.name}.old{UNFINISHED}")
        place.rename(old)
        new.rename(place)
        shutil.rmtree(old, ignore_errors=True)
    else:
        new.rename(place)


def _checksum(dataset: xr.Dataset, chunk: int) -> int:
    """Checksum of a chunk's number, and of all names, dimensions and values.

    A chunk that was copied into another's place is damaged there. All NaNs count as the same.
    """
    total = zlib.crc32(f"chunk {chunk}".encode())
    for name, rows in sorted(dataset.variables.items(), key=lambda item: str(item[0])):
        values = rows.values
        if np.issubdtype(values.dtype, np.floating):
            values = np.where(np.isnan(values), np.nan, values)
        total = zlib.crc32(f"{name} {rows.dims} {values.dtype} {values.shape}".encode(), total)
        total = zlib.crc32(values.tobytes(), total)
    return total
