"""Gains for every arm of the catalogue, still, on a truck and on a ship.

    python scripts/tune_arms.py [--quick] [--arms A B] [--out FOLDER] [--gains FILE]

For each arm and environment it tunes the paper's law with its bias compensated, with ideal hardware
and with the arm's own profile where there is one, and compares the paper's gains, the suggested and
the tuned ones on 1,000 fresh paths. Each path has a robot of its own (20 % of mass), an amplitude
of its own (home + A sin t, A from 0.15 to 0.45 rad or m) and starts 0.05 off in every joint. The
tuner may not ask for more torque rate than the paper's gains do. Each case is written to
tuned-arms.json as soon as it is done, and the next run goes on there; robots/gains.toml is made of
the record. It takes some 40 minutes on two cores.
"""

import argparse
import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.model.urdf.catalogue import catalogue, robots_folder
from ftcfa.report.terminal import print_line, print_table
from ftcfa.study.tuning.result import FRESH
from ftcfa.study.tuning.start import suggested

FIGURES = Path(__file__).parent / "figures"
RECORD = "tuned-arms.json"
AXES = ("longitudinal", "transverse", "vertical")
TRUCK = ftcfa.ShapedNoise([f"mil_std_810g_highway_truck_{axis}" for axis in AXES])
PROFILES = {"panda": "fr3", "ur5": "ur5e", "so101": "so101"}
"""Arms with a profile: their own, or that of their successor."""
STEPS = {"still": 1e-3, "truck": 2.5e-4, "ship": 1e-3}
"""Longest integration step [s]."""
SHIP = 0.2, 0.1, 1.0
"""Frequency [Hz], damping and rms acceleration [m/s^2] of the ship: an example."""
DURATION, VALIDATION, SEED = 3.0, 1000, 0
BUDGET = {"generations": 25, "candidates": 20, "paths": 32}
SHOWN = ("late_rms_error", "settling_time", "rms_torque_rate", "failed")


def sea(frequency: float, damping: float, rms: float) -> ftcfa.ShapedNoise:
    """Noise about a frequency [Hz] of some rms acceleration [m/s^2], alike in three axes."""
    w = 2 * np.pi * frequency
    A = np.array([[0.0, 1.0], [-(w**2), -2 * damping * w]])
    B = np.array([[0.0], [rms * np.sqrt(4 * damping * w)]])
    return ftcfa.ShapedNoise([ftcfa.LinearFilter(A, B, np.array([[0.0, 1.0]]))] * 3)


def loop(robot: str, environment: str, hardware: str) -> ftcfa.ClosedLoop:
    """An arm under the paper's law with the paper's gains."""
    arm = ftcfa.load_arm(robot)
    profile = ftcfa.hardware_profile(hardware)
    period = profile.period or 1e-3
    excitation = {"still": None, "truck": TRUCK, "ship": sea(*SHIP)}[environment]
    base = ftcfa.BaseAcceleration("xyz")
    return ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        None if excitation is None else ftcfa.Vibration(base, excitation),
        period=period,
        substeps=round(period / STEPS[environment]),
        q0=arm.home + 0.05,
        uncertainty=ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1),
        hardware=None if hardware == "ideal" else profile,
        spread={"reference_scale": (0.5, 1.5)},
    )


def case(robot: str, environment: str, hardware: str, quick: bool) -> dict[str, Any]:
    """Gains tuned for one case, and what the paper's, the suggested and the tuned ones do."""
    budget = {"generations": 2, "candidates": 4, "paths": 4} if quick else BUDGET
    it, begun = loop(robot, environment, hardware), time.monotonic()
    tuning = ftcfa.tune(it, DURATION, seed=SEED, **budget)
    seconds = time.monotonic() - begun
    loops = {"paper": it, "suggested": suggested(it), "tuned": tuning.loop}
    paths = 8 if quick else VALIDATION
    found = ftcfa.compare(loops, paths, DURATION, seed=SEED ^ FRESH)
    names = [str(name) for name in found["loop"].values]
    rows = {
        name: {
            metric: numbers(found.sel(loop=name, metric=metric)) for metric in SHOWN
        }
        for name in names
    }  # fmt: skip
    rows.setdefault("tuned", rows["paper"])
    return {
        "arm": robot, "environment": environment, "hardware": hardware, "period": it.period,
        "gains": tuning.gains, "answer": tuning.answer, "broken": list(tuning.broken),
        "seconds": seconds, "candidates": tuning.tried, "paths": paths, "seed": SEED,
        "date": datetime.now(UTC).date().isoformat(), "rows": rows,
        "cost in the search": finite(tuning.cost_in_search), "cost": finite(tuning.cost),
    }  # fmt: skip


def numbers(one: Any) -> dict[str, Any]:
    """Mean with its interval, median, 95 % quantile, and median difference from the paper's."""
    values = np.nan_to_num(one["values"].values, nan=np.inf, posinf=np.inf)
    median, q95 = np.quantile(values, [0.5, 0.95], method="higher")
    return {
        "mean": [finite(x) for x in one["mean"].values],
        "median": finite(median),
        "q95": finite(q95),
        "less than paper": [finite(x) for x in one["median_difference"].values],
    }


def finite(x: float) -> float | None:
    """A number for JSON."""
    return float(x) if np.isfinite(x) else None


def gains_file(record: list[dict[str, Any]]) -> str:
    """robots/gains.toml."""
    data: dict[str, Any] = {}
    for it in record:
        kept = {key: it[key] for key in ("period", "seed", "date", "answer", "gains")}
        for name in ("paper", "tuned"):
            row = it["rows"][name]["late_rms_error"]
            kept[f"error_{name}"] = [x for x in (row["median"], row["q95"]) if x is not None]
        data.setdefault(it["arm"], {}).setdefault(it["environment"], {})[it["hardware"]] = kept
    head = [
        "Gains of FTCF with its bias compensated, tuned by scripts/tune_arms.py: arm, environment,",
        "hardware. error_paper and error_tuned: median and 95 % quantile of the rms error [rad or",
        "m] on 1,000 fresh paths; empty where paths diverged. See `ftcfa.tuned_law`.",
    ]
    comments = "".join(f"# {line}\n" for line in head)
    return f"{comments}\n{tomli_w.dumps(data)}"


def main() -> None:
    """Run what is missing, write the gains, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one arm, tiny: seconds")
    parser.add_argument("--arms", nargs="+", default=list(catalogue()), help="arms to tune")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the record")
    parser.add_argument("--gains", type=Path, default=robots_folder() / "gains.toml")
    options = parser.parse_args()
    make_folder(options.out)
    file = options.out / RECORD
    record = json.loads(file.read_text()) if file.exists() else []
    done = {(it["arm"], it["environment"], it["hardware"]) for it in record}
    arms = ["double_pendulum"] if options.quick else options.arms
    for robot in arms:
        for environment in STEPS:
            for hardware in ("ideal", *([PROFILES[robot]] if robot in PROFILES else [])):
                if (robot, environment, hardware) not in done:
                    record.append(case(robot, environment, hardware, options.quick))
                    write_whole(file, json.dumps(record, indent=1).encode())
    place = {robot: i for i, robot in enumerate(catalogue())}
    record.sort(key=lambda it: (place[it["arm"]], list(STEPS).index(it["environment"])))
    write_whole(file, json.dumps(record, indent=1).encode())
    write_whole(options.gains, gains_file(record).encode())
    show(record)


def show(record: list[dict[str, Any]]) -> None:
    """Print the table."""
    console = Console(highlight=False, width=120)
    print_line("rms error, median and 95 % [mrad]; torque rate [N m/s]; settling [s]\n", console)
    heads = ["arm", "base", "hardware", "paper", "suggested", "tuned", "seconds"]
    rows = [
        [
            it["arm"], it["environment"], it["hardware"],
            *(cell(it["rows"][name]) for name in ("paper", "suggested", "tuned")),
            f"{it['seconds']:.0f}",
        ]
        for it in record
    ]  # fmt: skip
    print_table(heads, rows, console)


def cell(row: dict[str, Any]) -> str:
    """Error, torque rate and settling in one cell."""
    error, settle, rate = (row[name] for name in SHOWN[:3])
    shown = [f"{1e3 * x:.3g}" if x is not None else "lost" for x in (error["median"], error["q95"])]
    speed = "lost" if rate["median"] is None else f"{rate['median']:,.0f}"
    return f"{shown[0]} ({shown[1]}) {speed} {settle['median'] or 0:.2f}"


if __name__ == "__main__":
    main()
