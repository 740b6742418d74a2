"""Ctrl-C, a real SIGINT to a process: no script runs on as if done, and what is done is kept."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import ftcfa
from ftcfa import Interrupted

STUDIES = {
    "ensemble": (
        "ftcfa.ensemble(pendulum(), 100_000, 1.0, chunk=100, progress=report)",
        "stop.partial.sizes['path'] % 100 == 0 < stop.partial.sizes['path'] < 100_000",
    ),
    "verify": (
        "ftcfa.verify(pendulum(), ftcfa.Specification(0.05, 0.555, share=0.75, budget=10**6), 0.8,"
        " progress=report)",
        "stop.partial.answer in ('yes', 'no', 'undecided')"
        " and stop.partial.verdict.low < stop.partial.verdict.high",
    ),
    "compare": (
        "ftcfa.compare({'a': pendulum(), 'b': pendulum(), 'c': pendulum()}, 100, 0.1, chunk=1,"
        " progress=report)",
        "list(stop.partial.loop.values) == ['a', 'b'] and stop.partial.sizes['path'] == 100",
    ),
}
"""Each study, and what holds of the result that its interruption carries."""
LATER = {"compare": 220}
"""Paths that are to be done before the interruption; else one chunk."""


def interrupted(script, done=1):
    """Exit status and output of a script that is interrupted once some paths are done."""
    text = (
        "import time, ftcfa; from small_loops import pendulum\n"
        "def report(done, total):\n"
        "    print(done, flush=True)\n"
        "    time.sleep(0.01)\n" + script
    )
    folders = [str(Path(__file__).parent), str(Path(ftcfa.__file__).parents[1])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
    command = [sys.executable, "-c", text]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=environment, **pipes) as process:
        while int(process.stdout.readline()) < done:
            pass
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate()
    return process.returncode, output, errors


@pytest.mark.parametrize("study", STUDIES)
def test_what_is_done_comes_with_the_exception(study):
    call, holds = STUDIES[study]
    script = (
        f"try:\n    {call}\nexcept Exception:\n    print('caught as an error')\n"
        f"except ftcfa.Interrupted as stop:\n    print({holds})\n"
    )
    status, output, errors = interrupted(script, LATER.get(study, 1))
    assert (status, output.splitlines()[-1]) == (0, "True"), errors


def test_a_script_that_does_not_handle_it_ends():
    status, output, errors = interrupted(f"{STUDIES['ensemble'][0]}\nprint('ran on')")
    assert status != 0
    assert "ran on" not in output
    assert "Interrupted: ensemble interrupted; what is done is in its attribute partial" in errors


def test_it_is_a_keyboard_interrupt():
    assert issubclass(Interrupted, KeyboardInterrupt)
    assert not issubclass(Interrupted, Exception)
