"""What does it cost to measure positions alone? Velocities by differences and by observers.

    python scripts/velocities.py [--quick] [--out FOLDER]

Panda follows home + 0.3 sin t under FTCF with its bias compensated, from 0.1 rad off in every
joint, on the floor of a truck, with ideal motors; its inertias are known to some 20 %. Encoders
have 12, 16 or 20 bit and no latency; one has noise of one step (rms) besides. Every estimator has
one parameter; the table has the smallest value among TRIED whose error is within 1 % of the least
with each encoder, on paths that the table does not use: a larger one only makes the torque rougher.
It takes some minutes, prints a table and writes velocities.json.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.report.terminal import print_line, print_table

FIGURES = Path(__file__).parent / "figures"
TRUCK = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]
ENCODERS = ((12, 0.0), (16, 0.0), (16, 1.0), (20, 0.0))
"""Resolution [bit], and rms noise in steps."""
PATHS, DURATION, ALIKE = 200, 4.0, 0.01
TRIALS, TRIAL_SEED = 16, 1
ARM = ftcfa.load_arm("panda")
START = 0.1
"""Distance of every joint from the reference at the start [rad]."""
TRIED = {
    "backward difference": (
        lambda x, _: ftcfa.BackwardDifference(x), (10.0, 30.0, 100.0, 300.0, np.inf)
    ),
    "Levant": (lambda x, _: ftcfa.Levant(x), (10.0, 30.0, 100.0, 300.0, 1000.0)),
    "model observer": (lambda x, _: ftcfa.ModelObserver(ARM, x), (10.0, 30.0, 100.0, 300.0, 1e3)),
    "Kalman": (
        lambda x, error: ftcfa.Kalman(ARM, x, error), (0.3, 1.0, 3.0, 10.0, 30.0)
    ),
}  # fmt: skip
"""Estimator to the function that makes it of its parameter and the encoder's rms error, and values
of the parameter: bandwidth [Hz], L [rad/s^2], L, density [rad/s^2/sqrt(Hz)]."""


RIVAL = "a stochastic law of positions"
"""`PositionFeedback`, whose parameter is the density of what the arm does not know."""
DENSITIES = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)


def loop(sensors: ftcfa.Sensors, law: Any = None) -> ftcfa.ClosedLoop:
    """Panda on the truck with some sensors, under FTCF or another law."""
    return ftcfa.ClosedLoop(
        ARM,
        law or ftcfa.FTCF(ARM, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=ARM.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration("xyz"), ftcfa.ShapedNoise(TRUCK)),
        substeps=4,
        q0=ARM.home + START,
        uncertainty=ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1),
        hardware=ftcfa.Hardware(sensors),
    )


def loops_of_positions(encoder: dict[str, float]) -> dict[str, dict[float, ftcfa.ClosedLoop]]:
    """Loops without measured velocities, by estimator and parameter."""
    error = np.hypot(encoder["resolution"] / np.sqrt(12.0), encoder["noise"])
    loops = {
        name: {x: loop(ftcfa.Sensors(**encoder, velocity=make(x, error))) for x in values}
        for name, (make, values) in TRIED.items()
    }
    laws = {x: ftcfa.PositionFeedback(ARM, acceleration=x, noise=error) for x in DENSITIES}
    rival = {x: loop(ftcfa.Sensors(**encoder), law) for x, law in laws.items()}
    return loops | {RIVAL: rival}


def best(loops: dict[float, ftcfa.ClosedLoop], trials: int, duration: float) -> float:
    """The smallest parameter whose loop is within ALIKE of the least error on trial paths."""
    errors = {}
    for value, it in loops.items():
        run = ftcfa.ensemble(it, trials, duration, seed=TRIAL_SEED)
        errors[value] = np.median(np.nan_to_num(run.late_rms_error, nan=np.inf))
    least = min(errors.values())
    return min(value for value, error in errors.items() if error <= (1.0 + ALIKE) * least)


def row(it: ftcfa.ClosedLoop, paths: int, duration: float) -> dict[str, float]:
    """Medians over the paths: error [rad], torque rate of the worst joint [N m/s], settling [s]."""
    run = ftcfa.ensemble(it, paths, duration)
    rates = run.rms_torque_rate.max("joint")
    return {
        "error": float(np.nanmedian(run.late_rms_error)),
        "rate": float(np.nanmedian(rates)),
        "oscillation": float(np.nanmedian(run.oscillation.max("joint"))),
        "settling": float(np.median(run.settling_time)),
        "kept": int(run.attrs["kept"]),
    }


def main() -> None:
    """Run all, print the table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few short paths: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the record")
    options = parser.parse_args()
    make_folder(options.out)
    paths, trials, duration = (2, 1, 0.2) if options.quick else (PATHS, TRIALS, DURATION)
    record: dict[str, Any] = {"paths": paths, "duration": duration, "rows": []}

    def add(estimator: str, it: ftcfa.ClosedLoop, **named: Any) -> None:
        record["rows"].append({"estimator": estimator, **named} | row(it, paths, duration))

    add("measured exactly", loop(ftcfa.Sensors()), bits=None, noise=0.0, parameter=None)
    for bits, steps in ENCODERS[:1] if options.quick else ENCODERS:
        resolution = 2 * np.pi / 2**bits
        encoder = {"resolution": resolution, "noise": steps * resolution}
        add("measured", loop(ftcfa.Sensors(**encoder)), bits=bits, noise=steps, parameter=None)
        for name, loops in loops_of_positions(encoder).items():
            value = best(loops, trials, duration)
            add(name, loops[value], bits=bits, noise=steps, parameter=value)
    show(record)
    for each in record["rows"]:
        each["parameter"] = None if each["parameter"] == np.inf else each["parameter"]
    write_whole(options.out / "velocities.json", json.dumps(record, indent=1).encode())


def show(record: dict[str, Any]) -> None:
    """Print the table."""
    console = Console(highlight=False, width=110)
    print_line(f"Panda on a truck, {record['paths']} paths of {record['duration']:g} s\n", console)
    heads = [
        "velocity", "bit", "noise", "parameter", "rms mrad", "N m/s", "N m > 20 Hz", "settle s",
        "kept",
    ]  # fmt: skip
    rows = [
        [
            each["estimator"], str(each["bits"] or ""), f"{each['noise']:g}",
            "" if each["parameter"] is None else f"{each['parameter']:g}",
            f"{1e3 * each['error']:.2f}", f"{each['rate']:,.0f}", f"{each['oscillation']:.2f}",
            f"{each['settling']:.3f}", f"{each['kept']}",
        ]
        for each in record["rows"]
    ]  # fmt: skip
    print_table(heads, rows, console)


if __name__ == "__main__":
    main()
