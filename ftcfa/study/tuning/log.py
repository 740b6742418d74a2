"""What a search has tried, generation by generation, in a file from which it goes on."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.files import local_path, read_bounded, write_whole

LARGEST_LOG = 2**28
"""Bytes of the largest file that is read."""


class Log:
    """Rows of numbers of each generation, in memory and in a JSON file if there is one.

    The file is written whole after each generation, so that whatever stops a search leaves the
    generations before.

    Args:
        file: The file, or None for memory alone.
        identity: What the numbers depend on; a file with another one is refused.

    Raises:
        ParameterError: If the file is of another search.
        FtcfaError: If it cannot be read.
    """

    def __init__(self, file: str | os.PathLike[str] | None, identity: dict[str, Any]) -> None:
        self._file: Path | None = None if file is None else local_path(file)
        self._identity = json.loads(json.dumps(identity))
        self.generations: list[dict[str, Array]] = []
        if self._file is not None and self._file.exists():
            self.generations = self._read(self._file)

    def _read(self, file: Path) -> list[dict[str, Array]]:
        remedy = "give another file, or delete this one"
        try:
            data = json.loads(read_bounded(file, LARGEST_LOG))
            rows = [{k: np.asarray(v, dtype=float) for k, v in it.items()} for it in data["rows"]]
            identity = data["identity"]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            got = f"not the file of a search ({error})"
            raise FtcfaError(f"tune store {file}", got, "", remedy) from error
        if identity != self._identity:
            names = {*identity, *self._identity}
            other = sorted(k for k in names if identity.get(k) != self._identity.get(k))
            got = f"of another search: {', '.join(other)} differ"
            raise ParameterError(f"tune store {file}", got, "the file of this search", remedy)
        return rows

    def add(self, row: dict[str, Array]) -> None:
        """Add a generation."""
        self.generations.append(row)
        if self._file is not None:
            rows = [{k: np.asarray(v).tolist() for k, v in it.items()} for it in self.generations]
            write_whole(self._file, json.dumps({"identity": self._identity, "rows": rows}).encode())
