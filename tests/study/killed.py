"""Kill an ensemble with SIGKILL at random moments, look at its store each time, and resume it.

    python killed.py FOLDER KILLS SEED

The ensemble runs in forks of this process, its code compiled, so that it begins at once. Prints
the kills made and the stores that were completed; raises if a store cannot be read or a result is
another one.
"""

import os
import random
import signal
import sys
import time
import traceback
from pathlib import Path

import xarray as xr
from small_loops import read_all, uncertain_pendulum

from ftcfa import ensemble

PATHS, CHUNK, DURATION = 200, 40, 0.05


def run(loop, store=None):
    """Five chunks, of which each takes as long to write as to run."""
    return ensemble(loop, PATHS, DURATION, chunk=CHUNK, threads=1, store=store)


def forked(work, *arguments):
    """Number of a process that does some work."""
    process = os.fork()
    if process:
        return process
    status = 1
    try:
        work(*arguments)
        status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def check(store, expected):
    """Every group can be read; a result that is there is the right one."""
    groups = read_all(store) if store.exists() else {}
    if "result" in groups:
        xr.testing.assert_identical(groups["result"], read_all(expected)["result"])


def main(folder, kills, seed):
    """Kill, look, resume."""
    rng, made, completed = random.Random(seed), 0, 0
    loop, expected = uncertain_pendulum(), folder / "expected"
    run(loop)  # compiles
    start = time.perf_counter()
    assert os.waitpid(forked(run, loop, expected), 0)[1] == 0
    whole = time.perf_counter() - start
    while made < kills:
        store = folder / f"store{completed}"
        process = forked(run, loop, store)
        time.sleep(rng.uniform(0.0, 0.6 * whole))
        os.kill(process, signal.SIGKILL)
        _, status = os.waitpid(process, 0)
        if os.WIFSIGNALED(status):
            made += 1
        else:
            assert status == 0
            completed += 1
        assert os.waitpid(forked(check, store, expected), 0)[1] == 0
    last = folder / f"store{completed}"
    assert os.waitpid(forked(run, loop, last), 0)[1] == 0
    assert (last / "result").exists()
    assert not list(last.rglob("*.part"))
    assert os.waitpid(forked(check, last, expected), 0)[1] == 0
    print(made, completed + 1)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
