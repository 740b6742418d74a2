"""The connection to a Dask cluster."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

ADDRESS = r"(tcp|tls|ucx|wss?)://.+:\d+"
"""Pattern of a scheduler's address."""
SECONDS_TO_ANSWER = 5
"""Time within which a scheduler must answer [s]."""


@contextmanager
def cluster(scheduler: str | None) -> Iterator[Any]:
    """Connect to a Dask cluster by the address of its scheduler; yields a client, or None.

    Raises:
        FtcfaError: If the package ``distributed`` is not installed.
        ParameterError: If no scheduler answers at the address, or the scheduler has no workers.
    """
    from ftcfa.errors import FtcfaError, ParameterError

    if scheduler is None:
        yield None
        return
    try:
        import distributed
    except ImportError as error:
        missing = "the package 'distributed' is not installed"
        remedy = "install it: pip install 'ftcfa[cluster]'"
        raise FtcfaError("--scheduler", missing, "", remedy) from error
    if not re.fullmatch(ADDRESS, scheduler):
        raise ParameterError("--scheduler", scheduler, "an address such as tcp://127.0.0.1:8786")
    try:
        client = distributed.Client(scheduler, timeout=SECONDS_TO_ANSWER)
    except OSError as error:
        silent = f"no answer from {scheduler} within {SECONDS_TO_ANSWER} s"
        expected = "the address of a Dask scheduler that runs"
        raise ParameterError("--scheduler", silent, expected) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=SECONDS_TO_ANSWER)
        except TimeoutError as error:
            raise ParameterError(
                "--scheduler", f"{scheduler} has no workers", "one or more", "start a dask worker"
            ) from error
        yield client
