"""How large does finite-time backstepping without a filter let the torque become?

    python scripts/rival_singularity.py [--out FOLDER] [--quick]

The derivative of its virtual control is infinite where a tracking error crosses zero. With a
shorter period, samples fall closer to these crossings and the law demands more torque. The plant
takes the same steps and has the same noise at every period of the controller. The script takes a
minute; it prints the largest torque that is demanded on each path, and writes
rival-singularity.png and rival-singularity.json.
"""

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

import ftcfa
from ftcfa.arrays import Array
from ftcfa.files import make_folder, write_whole
from ftcfa.report.figures import BLUE, DASHED, GREEN, GREY, ORANGE, STYLE, page, rendered
from ftcfa.report.terminal import print_line, print_table
from ftcfa.study.reproduction import Case, closed_loop

STEP = 0.125e-3
"""Integration step of the plant [s]."""
TICKS = (32, 16, 8, 4, 2, 1)
"""Numbers of steps in a period: periods of 4 to 0.125 ms."""
LAWS = {
    "FiniteTimeBackstepping": ("exact, no filter", ORANGE),
    "FiniteTimeBackstepping-regularised": ("regularised within 0.01 rad", GREEN),
    "FTCF": ("command-filtered (the paper)", BLUE),
}
DURATION, CHUNK = 5.0, 8


def pendulum(law: str, ticks: int) -> ftcfa.ClosedLoop:
    """The loop of the paper's study under a law."""
    loop = closed_loop(Case(noise="psd"))
    controller = ftcfa.CONTROLLERS[law](loop.arm)
    return replace(loop, controller=controller, period=ticks * STEP, substeps=ticks)


def panda(law: str, ticks: int) -> ftcfa.ClosedLoop:
    """Panda about its home posture, started 0.05 rad away from it."""
    arm = ftcfa.load_arm("panda")
    shaken = ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1))
    reference = ftcfa.Sinusoid(0.3, offset=arm.home)
    return ftcfa.ClosedLoop(
        arm, ftcfa.CONTROLLERS[law](arm), reference, shaken, ticks * STEP, ticks, q0=arm.home + 0.05
    )


ARMS: Mapping[str, Callable[[str, int], ftcfa.ClosedLoop]] = {"pendulum": pendulum, "Panda": panda}
Demands = dict[tuple[str, str, int], Array]


def demands(loop: ftcfa.ClosedLoop, paths: int, duration: float) -> Array:
    """Largest torque that is demanded of any joint on each path, shape (paths,) [N m]."""
    largest = []
    for start in range(0, paths, CHUNK):
        numbers = range(start, min(start + CHUNK, paths))
        ran = ftcfa.simulate_paths(loop, numbers, duration, signals=["u_command"])
        largest.append(np.abs(ran.u_command).max(("time", "joint")).values)
    return np.concatenate(largest)


def print_tables(result: Demands) -> None:
    """Print the median and the largest of all paths, by period and law."""
    console = Console(highlight=False)
    labels = (label.replace(" ", "\n", 1) for label, _ in LAWS.values())  # they fit in 80 columns
    heads = ["period\n[ms]", *(f"{label}\nmedian, largest" for label in labels)]
    for arm in ARMS:
        rows = []
        for ticks in TICKS:
            values = (result[arm, law, ticks] for law in LAWS)
            cells = (f"{np.median(one):.4g}, {one.max():.4g}" for one in values)
            rows.append([f"{1e3 * ticks * STEP:g}", *cells])
        print_line(f"{arm}: largest demanded torque of a path [N m]", console, "bold")
        print_table(heads, rows, console, "r")
        console.print()


@mpl.rc_context(STYLE)
def figure(result: Demands) -> Figure:
    """Demanded torque against the period, an arm a panel."""
    drawn = page(3.6, "Largest demanded torque of a path")
    periods = 1e3 * STEP * np.array(TICKS)
    for ax, arm in zip(drawn.subplots(1, len(ARMS)), ARMS, strict=True):
        for law, (label, colour) in LAWS.items():
            rows = [result[arm, law, ticks] for ticks in TICKS]
            ax.loglog(periods, np.median(rows, axis=1), color=colour, marker="o", ms=3, label=label)
            ax.loglog(periods, np.max(rows, axis=1), color=colour, marker="^", ms=3, lw=0)
        first = np.median(result[arm, next(iter(LAWS)), TICKS[0]])
        slope = first * (periods / periods[0]) ** -0.4
        ax.loglog(periods, slope, color=GREY, linestyle=DASHED, label=r"slope $\kappa - 1$")
        ax.set_title(arm)
        ax.set_xlabel("period [ms]")
        ax.set_xticks(periods, [f"{period:g}" for period in periods])
        ax.minorticks_off()
        ax.invert_xaxis()
    drawn.axes[0].set_ylabel("torque [N m]")
    handles = drawn.axes[0].get_legend_handles_labels()
    title = "lines: median of the paths, triangles: largest"
    drawn.legend(*handles, loc="outside lower center", ncols=2, frameon=False, title=title)
    return drawn


def main() -> None:
    """Run all laws at all periods, print the tables, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the figure")
    parser.add_argument("--quick", action="store_true", help="few short paths: seconds")
    options = parser.parse_args()
    make_folder(options.out)
    paths, duration = (4, 0.5) if options.quick else (64, DURATION)
    result = {
        (arm, law, ticks): demands(make(law, ticks), paths, duration)
        for arm, make in ARMS.items()
        for law in LAWS
        for ticks in TICKS
    }
    print_tables(result)
    medians = {arm: {law: [float(np.median(result[arm, law, ticks])) for ticks in TICKS]
                     for law in LAWS} for arm in ARMS}  # fmt: skip
    periods = [1e3 * ticks * STEP for ticks in TICKS]
    record = json.dumps({"periods": periods, "medians": medians}, indent=1)
    write_whole(options.out / "rival-singularity.json", record.encode())
    write_whole(options.out / "rival-singularity.png", rendered(figure(result))["png"])


if __name__ == "__main__":
    main()
