"""What does it cost to measure positions alone? Velocities by differences and by observers.

    python scripts/velocities.py [--quick] [--out FOLDER]

Panda follows home + 0.3 sin t under FTCF with its bias compensated, from 0.1 rad off in every
joint, on the floor of a truck, with ideal motors; its inertias are known to some 20 %. Encoders
have 12, 16 or 20 bit, no other noise and no latency. Every estimator has one parameter; the table
has the value among TRIED that gives the least error with each encoder, on paths that the table
does not use. It takes some minutes, prints a table and writes velocities.json.
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
BITS = (12, 16, 20)
PATHS, DURATION = 200, 4.0
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
        lambda x, step: ftcfa.Kalman(ARM, x, step / np.sqrt(12.0)), (0.3, 1.0, 3.0, 10.0, 30.0)
    ),
}  # fmt: skip
"""Estimator to the function that makes it of its parameter and the encoder's step, and values of
the parameter: bandwidth [Hz], L [rad/s^2], L, density [rad/s^2/sqrt(Hz)]."""


LQG = "computed torque on the Kalman filter"
"""The stochastic law without joint velocities: feedback of the nominal error's estimate."""


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


def best(name: str, resolution: float, trials: int, duration: float) -> tuple[float, Any]:
    """The parameter with the least median error on trial paths, and its estimator."""
    make, values = TRIED[name]
    errors = []
    for value in values:
        sensors = ftcfa.Sensors(resolution, velocity=make(value, resolution))
        run = ftcfa.ensemble(loop(sensors), trials, duration, seed=TRIAL_SEED)
        errors.append(np.median(np.nan_to_num(run.late_rms_error, nan=np.inf)))
    value = values[int(np.argmin(errors))]
    return value, make(value, resolution)


def row(sensors: ftcfa.Sensors, paths: int, duration: float, law: Any = None) -> dict[str, float]:
    """Medians over the paths: error [rad], torque rate of the worst joint [N m/s], settling [s]."""
    run = ftcfa.ensemble(loop(sensors, law), paths, duration)
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
    measured = {"estimator": "measured exactly", "bits": None, "parameter": None}
    record["rows"].append(measured | row(ftcfa.Sensors(), paths, duration))
    for bits in BITS:
        resolution = 2 * np.pi / 2**bits
        named = {"estimator": "measured", "bits": bits, "parameter": None}
        record["rows"].append(named | row(ftcfa.Sensors(resolution), paths, duration))
        for name in TRIED:
            value, estimator = best(name, resolution, trials, duration)
            sensors = ftcfa.Sensors(resolution, velocity=estimator)
            named = {"estimator": name, "bits": bits, "parameter": value}
            record["rows"].append(named | row(sensors, paths, duration))
        named |= {"estimator": LQG}
        record["rows"].append(named | row(sensors, paths, duration, ftcfa.ComputedTorque(ARM)))
    show(record)
    for each in record["rows"]:
        each["parameter"] = None if each["parameter"] == np.inf else each["parameter"]
    write_whole(options.out / "velocities.json", json.dumps(record, indent=1).encode())


def show(record: dict[str, Any]) -> None:
    """Print the table."""
    console = Console(highlight=False, width=110)
    print_line(f"Panda on a truck, {record['paths']} paths of {record['duration']:g} s\n", console)
    heads = ["velocity", "bit", "parameter", "rms mrad", "N m/s", "N m > 20 Hz", "settle s", "kept"]
    rows = [
        [
            each["estimator"], str(each["bits"] or ""),
            "" if each["parameter"] is None else f"{each['parameter']:g}",
            f"{1e3 * each['error']:.2f}", f"{each['rate']:,.0f}", f"{each['oscillation']:.2f}",
            f"{each['settling']:.3f}", f"{each['kept']}",
        ]
        for each in record["rows"]
    ]  # fmt: skip
    print_table(heads, rows, console)


if __name__ == "__main__":
    main()
