"""Which gains matter?

    python scripts/which_gains_matter.py [--quick] [--out FOLDER]

Each gain of the paper's law (bias compensated) alone is a quarter to four times as large, all
others held, about the paper's gains and about tuned ones: Panda on the floor of a truck, and the
paper's double pendulum under its white noise, robots that differ from the nominal one by some 20 %
of mass, ideal hardware, 64 paths; kappa stays between 0.3 and 1. Shown is the rms error late in the
run of the worst 5 % of the paths, over that with the gains as they are. It takes some two minutes,
prints the numbers and writes which-gains-matter.png and which-gains-matter.json.
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
AXES = ("longitudinal", "transverse", "vertical")
TRUCK = ftcfa.ShapedNoise([f"mil_std_810g_highway_truck_{axis}" for axis in AXES])
ERROR = ftcfa.Objective((ftcfa.Term("late_rms_error"),))
DURATION, PATHS, SPREAD = 3.0, 64, ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1)
COLOURS = {
    "c1": "#0072B2", "c2": "#D55E00", "k1": "#56B4E9", "k2": "#E69F00", "kappa": "#000000",
    "iota": "#009E73", "lambda_": "#CC79A7", "r1": "#999999", "r2": "#BBBBBB",
}  # fmt: skip
LABELS = {"kappa": r"$\kappa$", "iota": r"$\iota$", "lambda_": r"$\lambda$"}
LABELS |= {"r1": "r1 (filter)", "r2": "r2 (filter)"}


def panda() -> ftcfa.ClosedLoop:
    """Panda on a truck."""
    arm = ftcfa.load_arm("panda")
    return ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration("xyz"), TRUCK),
        substeps=4,
        uncertainty=SPREAD,
    )


def pendulum() -> ftcfa.ClosedLoop:
    """The paper's pendulum under its noise."""
    arm = ftcfa.load_arm("double_pendulum")
    noise = ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1))
    law = ftcfa.FTCF(arm, compensation="bias")
    reference = ftcfa.Sinusoid([1.5, 1.0], [1.0, 2.0])
    return ftcfa.ClosedLoop(arm, law, reference, noise, uncertainty=SPREAD)


def cases(quick: bool) -> dict[str, ftcfa.ClosedLoop]:
    """Loops by title."""
    given = {"Panda on a truck": panda(), "double pendulum": pendulum()}
    budget = {"generations": 2, "candidates": 4, "paths": 4} if quick else {"paths": 32}
    found = {}
    for title, loop in given.items():
        found[f"{title}, the paper's gains"] = loop
        tuned = ftcfa.tune(loop, 0.3 if quick else DURATION, **budget).loop
        found[f"{title}, tuned gains"] = replace(loop, controller=tuned.controller)
    return found


def of_loop(loop: ftcfa.ClosedLoop, quick: bool) -> dict[str, Any]:
    """Error over that of the gains as they are, by gain and factor."""
    duration, paths = (0.3, 4) if quick else (DURATION, PATHS)
    found = ftcfa.sensitivity(loop, duration, ERROR, paths=paths)
    ratio = (found.cost / found.cost.sel(factor=1.0, method="nearest")).values
    names = [str(name).rpartition(".")[2] for name in found["parameter"].values]
    values = [[float(x) if np.isfinite(x) else None for x in row] for row in ratio]
    rows = dict(zip(names, values, strict=True))
    return {"factors": found["factor"].values.tolist(), "ratio": rows}


def drawn(record: dict[str, Any]) -> Figure:
    """A panel for each loop."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 5.6), layout="constrained")
        panels = figure.subplots(2, 2, sharex=True)
        for axes, (title, one) in zip(panels.ravel(), record.items(), strict=True):
            for name, ratio in one["ratio"].items():
                values = np.array([np.nan if x is None else x for x in ratio])
                width = 1.6 if name in ("c1", "c2", "k1", "k2", "kappa") else 1.0
                label = LABELS.get(name, name)
                axes.plot(one["factors"], values, color=COLOURS[name], lw=width, label=label)
            axes.set(xscale="log", yscale="log", ylim=(0.3, 10.0), title=title)
            axes.set_xticks([0.25, 0.5, 1, 2, 4], ["¼", "½", "1", "2", "4"], minor=False)
            axes.set_yticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"], minor=False)
            axes.minorticks_off()
        for axes in panels[1]:
            axes.set_xlabel("factor of one gain")
        for axes in panels[:, 0]:
            axes.set_ylabel("error of the worst 5 %, relative")
        panels[1, 0].legend(fontsize=7, frameon=False, ncols=3, loc="lower center")
    return figure


def main() -> None:
    """Run all, print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few short paths: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for record and figure")
    options = parser.parse_args()
    make_folder(options.out)
    loops = cases(options.quick)
    record = {title: of_loop(loop, options.quick) for title, loop in loops.items()}
    show(record)
    write_whole(options.out / "which-gains-matter.json", json.dumps(record, indent=1).encode())
    write_whole(options.out / "which-gains-matter.png", rendered(drawn(record))["png"])


def show(record: dict[str, Any]) -> None:
    """Print the ends of each line."""
    console = Console(highlight=False, width=110)
    for title, one in record.items():
        print_line(f"\n{title}: error over that of the gains as they are\n", console)
        middle = one["factors"].index(min(one["factors"], key=lambda x: abs(np.log(x) - np.log(2))))
        half = one["factors"].index(min(one["factors"], key=lambda x: abs(np.log(x) + np.log(2))))
        shown = {"¼": 0, "½": half, "2": middle, "4": len(one["factors"]) - 1}
        rows = [
            [name, *("lost" if r[i] is None else f"{r[i]:.2f}" for i in shown.values())]
            for name, r in one["ratio"].items()
        ]
        print_table(["gain", *(f"x {name}" for name in shown)], rows, console)


if __name__ == "__main__":
    main()
