"""How late and how coarse may measurements be, for every law on every arm?

    python scripts/margins.py [--quick] [--out FOLDER]

Each arm follows home + 0.3 sin t on a base that white noise of 0.1 (psd) shakes, with ideal motors
at 1 kHz. The latency of q and v grows in steps of 0.5 ms, the resolution of q in powers of two, a
step a path, until the error has doubled and until the loop is lost (a joint a quarter turn off its
reference at the end). Medians over seeds. It takes a quarter of an hour, prints tables and writes
margins.json.
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
LATENCIES = 5e-4 * np.arange(61)
"""Latencies [s]."""
RESOLUTIONS = 2.0 ** np.arange(-20, 1)
"""Resolutions, of which the first is as good as none [rad]."""
DIFFERENCE = 100.0
"""Corner of the low-pass of velocities where positions are quantised [Hz]."""
LOST = np.pi / 2


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


def varied(loop: ftcfa.ClosedLoop, name: str, values: Any) -> dict[str, Any]:
    """The values of a sensor's number, a path each; a law of positions knows the resolution."""
    given = {f"hardware.sensors.{name}": values}
    if name == "resolution" and isinstance(loop.controller, ftcfa.PositionFeedback):
        given["controller.noise"] = np.maximum(values / np.sqrt(12.0), loop.controller.noise)
    return given


def errors(
    loop: ftcfa.ClosedLoop, sensors: ftcfa.Sensors, name: str, values: Any, options: Any
) -> tuple[Any, Any]:
    """Medians over seeds of the rms error of each value, and which loops are lost."""
    it = replace(loop, hardware=ftcfa.Hardware(sensors))
    found, lost = [], []
    for seed in range(options["seeds"]):
        paths = ftcfa.simulate_paths(
            it, np.zeros(len(values), dtype=int).tolist(), options["duration"], seed=seed,
            vary=varied(it, name, values), record_every=5,
        )  # fmt: skip
        late = paths.ote.sel(time=slice(options["duration"] / 2, None))
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
            late = ftcfa.Sensors(largest_latency=float(LATENCIES[-1]))
            coarse = ftcfa.Sensors(velocity=ftcfa.BackwardDifference(DIFFERENCE))
            rows[law] = {
                "latency": margin(LATENCIES, *errors(loop, late, "latency", LATENCIES, how)),
                "resolution": margin(
                    RESOLUTIONS, *errors(loop, coarse, "resolution", RESOLUTIONS, how)
                ),
            }
        record["arms"][robot] = rows
        show(robot, rows)
    write_whole(options.out / "margins.json", json.dumps(record, indent=1).encode())


def show(robot: str, rows: dict[str, Any]) -> None:
    """Print the table of an arm."""
    console = Console(highlight=False, width=110)
    print_line(f"\n{robot}\n", console)
    heads = ["law", "latency doubles", "loses", "resolution doubles", "loses"]

    def cells(one: dict[str, Any], scale: float, unit: str, largest: float) -> list[str]:
        return [
            f"> {scale * largest:.3g} {unit}" if one[k] is None else f"{scale * one[k]:.3g} {unit}"
            for k in ("doubled", "lost")
        ]

    table = [
        [
            law, *cells(row["latency"], 1e3, "ms", LATENCIES[-1]),
            *cells(row["resolution"], 1e3, "mrad", RESOLUTIONS[-1]),
        ]
        for law, row in rows.items()
    ]  # fmt: skip
    print_table(heads, table, console)


if __name__ == "__main__":
    main()
