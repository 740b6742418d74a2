"""How good is the paper's law beside its rivals, when all are tuned alike?

    python scripts/fair_comparison.py [--quick] [--out FOLDER]

Every law is tuned with the same budget, objective and limits on Panda, whose inertias are known to
some 20 %, with ideal hardware and with the profile fr3, on a base that stands still and on the
floor of a truck, there with and without a calibrated accelerometer whose reading is fed
forward. Reference: home + A sin t with A from 0.15 to 0.45 rad, from 0.05 rad off in every joint.
Objective: the error late in the run of the worst 5 % of the paths, and 1 mrad for each second of
settling. Limits: 1,000 N m/s of torque rate (rms, the worst joint), 1 % of the samples saturated,
1 % limited by the driver's rate limit, 99 % of the paths kept. The table has 1,000 fresh paths.
Then the fronts of error and torque rate on the truck, ideal hardware.

Each cell is written to fair-comparison.json as soon as it is done, and the next run goes on there.
All of it takes about an hour.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.report.figures import STYLE, rendered
from ftcfa.report.terminal import print_line, print_table

FIGURES = Path(__file__).parent / "figures"
RECORD = "fair-comparison.json"
TRUCK = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]
ARM = ftcfa.load_arm("panda")
LAWS = {
    "FTCF, no compensation": lambda: ftcfa.FTCF(ARM),
    "FTCF": lambda: ftcfa.FTCF(ARM, compensation="bias"),
    "CommandFilteredBackstepping": lambda: ftcfa.CommandFilteredBackstepping(ARM),
    "ComputedTorque": lambda: ftcfa.ComputedTorque(ARM),
    "FiniteTimeBackstepping": lambda: ftcfa.FiniteTimeBackstepping(ARM, width=0.01),
    "PDGravity": lambda: ftcfa.PDGravity(ARM),
    "PositionFeedback": lambda: ftcfa.PositionFeedback(ARM),
    "SlotineLi": lambda: ftcfa.SlotineLi(ARM),
    "SuperTwisting": lambda: ftcfa.SuperTwisting(ARM),
}
"""Laws by name. Stochastic backstepping is computed torque, and is left out."""
ENVIRONMENTS = ("still", "truck", "truck, accelerometer")
HARDWARE = ("ideal", "fr3")
OBJECTIVE = ftcfa.Objective(
    terms=(ftcfa.Term("late_rms_error"), ftcfa.Term("settling_time", 1e-3, "mean")),
    limits=(
        ftcfa.Limit("rms_torque_rate", 1000.0),
        ftcfa.Limit("saturated", 0.01),
        ftcfa.Limit("rate_limited", 0.01),
    ),
    kept=0.99,
)
DURATION, BAND = 3.0, 30.0
BUDGET = {"generations": 25, "candidates": 20, "paths": 32}
FRONT = {"generations": 20, "candidates": 30, "paths": 16}
VALIDATION = 1000
SHOWN = ("late_rms_error", "rms_torque_rate", "settling_time", "rate_limited", "saturated")
COLOURS = (
    "#000000", "#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00", "#CC79A7", "#999999",
    "#882255",
)  # fmt: skip


def loop(law: str, hardware: str, environment: str) -> ftcfa.ClosedLoop:
    """A law on Panda with its default gains."""
    controller: Any = LAWS[law]()
    moved = environment != "still"
    profile = ftcfa.hardware_profile(hardware)
    if "accelerometer" in environment:
        sensor = replace(ftcfa.accelerometer_profile("low_noise_mems"), bias=0.0)  # calibrated
        profile = replace(profile, accelerometer=sensor)
        controller = ftcfa.FeedForward(ARM, controller, BAND)
    truck = ftcfa.Vibration(ftcfa.BaseAcceleration("xyz"), ftcfa.ShapedNoise(TRUCK))
    return ftcfa.ClosedLoop(
        ARM,
        controller,
        ftcfa.Sinusoid(0.3, offset=ARM.home),
        truck if moved else None,
        substeps=4 if moved else 1,
        q0=ARM.home + 0.05,
        uncertainty=ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1),
        hardware=None if hardware == "ideal" and not profile.senses_base else profile,
        spread={"reference_scale": (0.5, 1.5)},
    )


def cell(law: str, hardware: str, environment: str, quick: bool) -> dict[str, Any]:
    """A law tuned, and what it does with default and tuned gains on fresh paths."""
    budget = {"generations": 2, "candidates": 4, "paths": 4} if quick else BUDGET
    tuning = ftcfa.tune(loop(law, hardware, environment), DURATION, OBJECTIVE, **budget)
    fresh = tuning.validate(8 if quick else VALIDATION)
    values = fresh["values"]
    rows = {}
    for row, name in ((0, "default"), (-1, "tuned")):
        one = values.isel(loop=row)
        rows[name] = {
            metric: [finite(x) for x in quantiles(one.sel(metric=metric).values)]
            for metric in SHOWN
        }
        rows[name]["mean rate"] = finite(np.mean(one.sel(metric="rms_torque_rate").values))
        rows[name]["failed"] = float(one.sel(metric="failed").mean())
    return {
        "law": law, "hardware": hardware, "environment": environment, "gains": tuning.gains,
        "answer": tuning.answer, "broken": list(tuning.broken), "candidates": tuning.tried,
        "cost": {
            "default": finite(fresh.attrs["cost_given"]), "fresh": finite(fresh.attrs["cost"]),
            "final": finite(tuning.cost), "search": finite(tuning.cost_in_search),
        },
        "excess": finite(fresh.attrs["excess"]),
        **rows,
    }  # fmt: skip


def quantiles(values: Any) -> list[float]:
    """Median and 95 % quantile; a path that diverged is the worst."""
    known = np.nan_to_num(values, nan=np.inf, posinf=np.inf)
    return np.quantile(known, [0.5, 0.95], method="higher").tolist()


def finite(x: float) -> float | None:
    """A number for JSON."""
    return float(x) if np.isfinite(x) else None


def fronts(law: str, quick: bool) -> dict[str, Any]:
    """Error against torque rate of a law, on the truck with ideal hardware."""
    budget = {"generations": 2, "candidates": 4, "paths": 4} if quick else FRONT
    terms = (ftcfa.Term("late_rms_error"), ftcfa.Term("rms_torque_rate", 1.0, "mean"))
    found = ftcfa.front(loop(law, "ideal", "truck"), DURATION, terms, **budget)
    return {"error": found["first"].values.tolist(), "rate": found["second"].values.tolist()}


def drawn(record: dict[str, Any]) -> Figure:
    """The fronts of all laws, and their tuned errors in all cells."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 4.2), layout="constrained")
        axes = figure.subplots()
        for colour, (law, one) in zip(COLOURS, record["fronts"].items(), strict=False):
            error = 1e3 * np.array(one["error"])
            axes.plot(one["rate"], error, "o-", ms=3, lw=1, color=colour, label=law)
        axes.axvline(1000.0, color="0.5", lw=0.8, ls="--")
        axes.set(xscale="log", yscale="log", xlim=(50, 2e4), ylim=(1, 1e3))
        axes.set_xlabel("torque rate of the worst joint, rms [N m/s]")
        axes.set_ylabel("rms error of the worst 5 % of the paths [mrad]")
        axes.legend(fontsize=7, frameon=False, ncols=2)
    return figure


def main() -> None:
    """Run what is missing, print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two cells, tiny: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for record and figure")
    options = parser.parse_args()
    make_folder(options.out)
    file = options.out / RECORD
    record = json.loads(file.read_text()) if file.exists() else {"cells": [], "fronts": {}}
    done = {(it["law"], it["hardware"], it["environment"]) for it in record["cells"]}
    cells = [(law, h, e) for e in ENVIRONMENTS for h in HARDWARE for law in LAWS]
    laws = list(LAWS)
    if options.quick:
        cells, laws = cells[1:3], laws[1:2]

    def save() -> None:
        write_whole(file, json.dumps(record, indent=1).encode())

    for key in cells:
        if key not in done:
            record["cells"].append(cell(*key, options.quick))
            save()
    for law in laws:
        if law not in record["fronts"]:
            record["fronts"][law] = fronts(law, options.quick)
            save()
    show(record)
    write_whole(options.out / "fair-comparison.png", rendered(drawn(record))["png"])


def show(record: dict[str, Any]) -> None:
    """Print the table."""
    console = Console(highlight=False, width=110)
    print_line(f"Tuned laws on {VALIDATION:,} fresh paths: error of the worst 5 %\n", console)
    heads = ["law", "hardware", "base", "default mrad", "tuned mrad", "N m/s", "settle s", "failed"]
    rows = [
        [
            it["law"], it["hardware"], it["environment"],
            *(mrad(it[which]["late_rms_error"][1]) for which in ("default", "tuned")),
            f"{it['tuned']['mean rate'] or np.inf:,.0f}",
            f"{it['tuned']['settling_time'][0] or 0:.2f}", f"{it['tuned']['failed']:.1%}",
        ]
        for it in record["cells"]
    ]  # fmt: skip
    print_table(heads, rows, console)


def mrad(x: float | None) -> str:
    """An error in milliradian."""
    return "lost" if x is None else f"{1e3 * x:.1f}"


if __name__ == "__main__":
    main()
