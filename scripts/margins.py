"""How late and how coarse may measurements be, and how late the motors, for every law and arm?

    python scripts/margins.py [--quick] [--out FOLDER]

Each arm follows home + 0.3 sin t on a base that white noise of 0.1 (psd) shakes, with ideal motors
at 1 kHz. The latency of q and v and the delay of the motors grow in steps of 0.5 ms, the resolution
of q in powers of two, a step a path, until the error has doubled and until the loop is lost (a
joint a quarter turn off its reference at the end). Medians over seeds. It takes a quarter of an
hour, prints tables and writes margins.json.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.report.terminal import print_line, print_table

FIGURES = Path(__file__).parent / "figures"
DURATION, SEEDS = 4.0, 3
TIMES = 5e-4 * np.arange(61)
"""Latencies and delays [s]."""
RESOLUTIONS = 2.0 ** np.arange(-20, 1)
"""Resolutions, of which the first is as good as none [rad]."""
DIFFERENCE = 100.0
"""Corner of the low-pass of velocities where positions are quantised [Hz]."""
LOST = np.pi / 2
LATEST = float(TIMES[-1])
TRIED: dict[str, tuple[str, Any, ftcfa.Hardware]] = {
    "latency": (
        "hardware.sensors.latency", TIMES, ftcfa.Hardware(ftcfa.Sensors(largest_latency=LATEST))
    ),
    "resolution": (
        "hardware.sensors.resolution", RESOLUTIONS,
        ftcfa.Hardware(ftcfa.Sensors(velocity=ftcfa.BackwardDifference(DIFFERENCE))),
    ),
    "delay": (
        "hardware.actuators.delay", TIMES,
        ftcfa.Hardware(actuators=ftcfa.Actuators(largest_delay=LATEST)),
    ),
}  # fmt: skip
"""What grows: its parameter, its values, and the hardware that has it."""


def loops(robot: str) -> dict[str, ftcfa.ClosedLoop]:
    """Every law on an arm, each with a latency that may vary."""
    arm = ftcfa.load_arm(robot)
    given = ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1)),
        substeps=2,
    )
    every = ftcfa.rivals(given)
    del every["as given"]  # which is FTCF
    return every


def varied(loop: ftcfa.ClosedLoop, parameter: str, values: Any) -> dict[str, Any]:
    """The values of a parameter, a path each; a law of positions knows the resolution."""
    given = {parameter: values}
    if values is RESOLUTIONS and isinstance(loop.controller, ftcfa.PositionFeedback):
        given["controller.noise"] = np.maximum(values / np.sqrt(12.0), loop.controller.noise)
    return given


def errors(loop: ftcfa.ClosedLoop, tried: str, duration: float, seeds: int) -> tuple[Any, Any]:
    """Medians over seeds of the rms error of each value, and which loops are lost."""
    parameter, values, hardware = TRIED[tried]
    it = replace(loop, hardware=hardware)
    found, lost = [], []
    for seed in range(seeds):
        paths = ftcfa.simulate_paths(
            it, np.zeros(len(values), dtype=int).tolist(), duration, seed=seed,
            vary=varied(it, parameter, values), record_every=5,
        )  # fmt: skip
        late = paths.ote.sel(time=slice(duration / 2, None))
        error = np.sqrt((late**2).mean("time", skipna=False)).values
        found.append(np.nan_to_num(error, nan=np.inf))
        last = np.abs(paths.q - paths.q_d).isel(time=-1).max("joint").values
        lost.append(~(last < LOST))
    return np.median(found, axis=0), np.median(lost, axis=0) > 0


def margin(values: Any, error: Any, lost: Any) -> dict[str, float | None]:
    """The first value at which the error has doubled, and at which the loop is lost."""

    def first(condition: Any) -> float | None:
        return float(values[np.argmax(condition)]) if np.any(condition) else None

    return {"error": float(error[0]), "doubled": first(error > 2 * error[0]), "lost": first(lost)}


def main() -> None:
    """Run all, print the tables, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one arm, short paths: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the record")
    options = parser.parse_args()
    make_folder(options.out)
    how = {"duration": 0.2 if options.quick else DURATION, "seeds": 1 if options.quick else SEEDS}
    record: dict[str, Any] = {**how, "arms": {}}
    for robot in ["double_pendulum"] if options.quick else catalogue():
        rows: dict[str, Any] = {}
        for law, loop in list(loops(robot).items())[: 1 if options.quick else None]:
            rows[law] = {
                name: margin(values, *errors(loop, name, **how))
                for name, (_, values, _) in TRIED.items()
            }
        record["arms"][robot] = rows
        show(robot, rows)
    write_whole(options.out / "margins.json", json.dumps(record, indent=1).encode())


def show(robot: str, rows: dict[str, Any]) -> None:
    """Print the table of an arm."""
    console = Console(highlight=False, width=110)
    print_line(f"\n{robot}\n", console)
    heads = ["law", *(f"{name} {what}" for name in TRIED for what in ("doubles", "loses"))]

    def cells(name: str, one: dict[str, Any]) -> list[str]:
        largest, unit = TRIED[name][1][-1], "mrad" if name == "resolution" else "ms"
        return [
            f"> {1e3 * largest:.3g} {unit}" if one[k] is None else f"{1e3 * one[k]:.3g} {unit}"
            for k in ("doubled", "lost")
        ]

    table = [
        [law, *(cell for name, one in row.items() for cell in cells(name, one))]
        for law, row in rows.items()
    ]
    print_table(heads, table, console)


if __name__ == "__main__":
    main()
