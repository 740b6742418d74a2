"""Ctrl-C, a real SIGINT to a process: no script runs on as if done, and what is done is kept."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import ftcfa
from ftcfa import Interrupted

STUDIES = {
    "ensemble": (
        "ftcfa.ensemble(pendulum(), 100_000, 1.0, chunk=100, threads=1, progress=report)",
        "stop.partial.sizes['path'] % 100 == 0 < stop.partial.sizes['path'] < 100_000",
    ),
    "verify": (
        "ftcfa.verify(pendulum(), ftcfa.Specification(0.05, 0.555, share=0.75, budget=10**6), 0.8,"
        " threads=1, progress=report)",
        "stop.partial.answer in ('yes', 'no', 'undecided')"
        " and stop.partial.verdict.low < stop.partial.verdict.high",
    ),
    "compare": (
        "ftcfa.compare({'a': pendulum(), 'b': pendulum(0.1), 'c': pendulum(0.2)}, 20, 0.1, chunk=1,"
        " threads=1, progress=report)",
        "list(stop.partial.loop.values) == ['a', 'b'] and stop.partial.sizes['path'] == 20",
    ),
}
"""Each study, and what holds of the result that its interruption carries."""
DONE = {"ensemble": 1, "verify": 1, "compare": 44}
"""Paths that are done when the interruption comes."""
BEGINNING = """
import time, ftcfa
from small_loops import pendulum

def report(done, total):
    print(done, flush=True)
    time.sleep(0.01)
"""
HANDLED = """
try:
    {call}
except Exception:
    print("caught as an error", flush=True)
except ftcfa.Interrupted as stop:
    print("result", {holds}, flush=True)
"""


def test_what_is_done_comes_with_the_exception_and_a_script_that_does_not_handle_it_ends():
    handled = [HANDLED.format(call=call, holds=holds) for call, holds in STUDIES.values()]
    script = "\n".join([BEGINNING, *handled, STUDIES["ensemble"][0], "print('ran on')"])
    folders = [str(Path(__file__).parent), str(Path(ftcfa.__file__).parents[1])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
    command = [sys.executable, "-c", script]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=environment, **pipes) as process:
        for study, paths in DONE.items():
            interrupt(process, paths)
            line = process.stdout.readline()
            while line.strip().isdecimal():
                line = process.stdout.readline()
            assert (study, line) == (study, "result True\n")
        interrupt(process, 1)
        output, errors = process.communicate()
    assert process.returncode != 0
    assert "ran on" not in output
    assert "Interrupted: ensemble interrupted; what is done is in its attribute partial" in errors


def interrupt(process, paths):
    """Send SIGINT once some paths are done."""
    while int(process.stdout.readline()) < paths:
        pass
    process.send_signal(signal.SIGINT)


def test_it_is_a_keyboard_interrupt():
    assert issubclass(Interrupted, KeyboardInterrupt)
    assert not issubclass(Interrupted, Exception)
