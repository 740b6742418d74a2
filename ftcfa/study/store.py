"""Chunks of an ensemble on disk: written whole or not at all, found again after any interruption.

    STORE/.zattrs              what was run: attributes ``identity`` and ``ftcfa_version``
    STORE/chunks/000007/       a chunk's Dataset
    STORE/result/              the summary, once there is one

The folder is a hierarchy of zarr groups, each readable by xarray alone, such as
``xarray.open_zarr(STORE, group="result")``. A group is written under another name beside its
place and then renamed, so that nothing half-written ever bears its name.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import xarray as xr
import zarr

from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.loop.describe import differences

CHUNKS, RESULT = "chunks", "result"
UNFINISHED = ".part"
ZARR_FORMAT: Final = 2
"""Version 3 has no stable type for texts of joints' names."""


class Store:
    """A folder of chunks.

    Args:
        path: The folder; made if it is not there.
        identity: What the chunks are of, as plain data.

    Raises:
        ParameterError: If the folder is of something else.
        FtcfaError: If it cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], identity: Mapping[str, Any]) -> None:
        self.path = Path(path)
        told = json.dumps(identity, sort_keys=True)
        if not self.path.exists():
            self._put("", lambda place: _root(place, told))
        self._check(told)
        for left in self.path.rglob(f"*{UNFINISHED}"):
            shutil.rmtree(left, ignore_errors=True)

    def _check(self, told: str) -> None:
        try:
            found = zarr.open_group(self.path, mode="r").attrs.get("identity")
        except (OSError, ValueError, zarr.errors.GroupNotFoundError) as error:
            raise ParameterError(
                str(self.path), "no store of an ensemble", "a new folder, or one that ensemble made"
            ) from error
        if found != told:
            differ = differences(json.loads(str(found)), json.loads(told)) if found else "all"
            raise ParameterError(
                str(self.path),
                f"a store of another experiment (they differ in {differ})",
                "the one that was begun",
                "choose another folder, or run the same experiment",
            )

    def __iter__(self) -> Iterator[int]:
        """Numbers of the chunks that are there."""
        folder = self.path / CHUNKS
        names = sorted(entry.name for entry in folder.iterdir()) if folder.exists() else []
        return (int(name) for name in names if name.isdecimal())

    def read(self, chunk: int) -> xr.Dataset:
        """A chunk that is there."""
        place = self.path / CHUNKS / f"{chunk:06d}"
        with xr.open_zarr(place, consolidated=False, chunks=None) as dataset:
            return dataset.load()

    def write(self, chunk: int, dataset: xr.Dataset) -> None:
        """Write a chunk.

        Raises:
            FtcfaError: If it cannot be written; what is there stays.
        """
        self._put(f"{CHUNKS}/{chunk:06d}", lambda place: _write(dataset, place))

    def write_result(self, dataset: xr.Dataset) -> None:
        """Write the summary, in place of the one that may be there.

        Raises:
            FtcfaError: If it cannot be written.
        """
        self._put(RESULT, lambda place: _write(dataset, place))

    def _put(self, name: str, write: Callable[[Path], None]) -> None:
        """Have a group written and then give it its name."""
        place = self.path / name
        unfinished = place.with_name(f"{place.name}.{os.getpid()}{UNFINISHED}")
        try:
            try:
                unfinished.parent.mkdir(parents=True, exist_ok=True)
                write(unfinished)
                _rename(unfinished, place)
            finally:
                shutil.rmtree(unfinished, ignore_errors=True)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise FtcfaError(
                str(self.path),
                f"cannot be written ({reason})",
                "",
                "what is there is whole: make room and run again to go on",
            ) from error


def _root(place: Path, told: str) -> None:
    group = zarr.open_group(place, mode="w", zarr_format=ZARR_FORMAT)
    group.attrs.update({"identity": told, "ftcfa_version": version("ftcfa")})
    group.create_group(CHUNKS)


def _write(dataset: xr.Dataset, place: Path) -> None:
    dataset.to_zarr(place, mode="w", consolidated=False, zarr_format=ZARR_FORMAT)


def _rename(new: Path, place: Path) -> None:
    """Give a folder its name, taking it from the one that bears it."""
    if place.exists():
        old = place.with_name(f"{place.name}.old{UNFINISHED}")
        place.rename(old)
        new.rename(place)
        shutil.rmtree(old, ignore_errors=True)
    else:
        new.rename(place)
