"""The paper's comparison as an ensemble: is kappa = 0.6 better than kappa = 1, and how surely?

    python scripts/ensemble_paper.py [--quick] [--paths N] [--out FOLDER]

The double pendulum of the paper's Section V, shaken by a random base acceleration, under the
finite-time law and the asymptotic one. Path i of both has the same noise (common random numbers),
so the difference is taken path by path and most of the noise cancels. The paper shows one path;
this script runs 10,000 paths of 20 s. A path has settled once its error stays below 0.05 rad until
the end of the run; a path that has not settled counts with the whole duration in the mean. The law
is the one as printed, with the noise as printed; it writes ensemble.png and ensemble.json.
"""

import argparse
import json
from pathlib import Path

import matplotlib as mpl
import numpy as np

from ftcfa import ensemble, settled_in_mean_square, settling
from ftcfa.files import make_folder, write_whole
from ftcfa.report.figures import BLUE, ORANGE, STYLE, draw_level, label_level, page, rendered
from ftcfa.statistics.moments import Moments, paired_differences
from ftcfa.study.reproduction import ASYMPTOTIC, BAND, FINITE_TIME, closed_loop

CASES = {"κ = 0.6": FINITE_TIME, "κ = 1": ASYMPTOTIC}
PATHS, DURATION = 10_000, 20.0
QUICK_PATHS, QUICK_DURATION = 500, 5.0
START = 1.0
"""Length of the view of the settling [s]."""
FIGURES = Path(__file__).parent / "figures"


def shown(estimate, unit):
    """Text of a value with its interval."""
    if np.isinf(estimate.low):
        return "not within the run"
    return f"{estimate.value:.5g} {unit} ({estimate.low:.5g} to {estimate.high:.5g})"


def measured(run):
    """What README says of a law."""
    times = settling(run)
    return {
        "settled": times.settled,
        "median": float(times.quantile(0.5).value) if times.settled > times.censored else None,
        "mean_square": [float(x) for x in late_mean_square(run)],
    }


def late_mean_square(run):
    """Mean-square error late in the run, with its interval."""
    return Moments.of(run["late_rms_error"].values ** 2).skewness_corrected()


def print_case(name, run):
    """Print mean square and settling of one law."""
    late, times = late_mean_square(run), settling(run)
    reached = settled_in_mean_square(run, BAND**2)
    print(f"{name}: {run.attrs['diverged']} diverged, {times.settled} settled to {BAND:g} rad")
    print(f"  mean-square error, late    {shown(late, 'rad^2')}")
    for p in (0.5, 0.95):
        print(f"  settled are {p:4.0%} by        {shown(times.quantile(p), 's')}")
    since = "not by the end" if np.isnan(reached) else f"from {reached:g} s on"
    print(f"  E|z1|^2 below {BAND**2:g} rad^2 {since} (97.5 % upper bound)")


def print_differences(first, second):
    """Print paired differences, kappa = 1 minus kappa = 0.6."""
    duration = first.attrs["duration"]
    square = [run["late_rms_error"].values ** 2 for run in (second, first)]
    capped = [np.minimum(run["settling_time"].values, duration) for run in (second, first)]
    print("difference, κ = 1 minus κ = 0.6, path by path")
    for label, pair, unit in (
        ("mean-square error, late", square, "rad^2"),
        (f"time to settle, {duration:g} s at most", capped, "s"),
    ):
        paired = paired_differences(*pair).student()
        apart = np.sqrt(sum(Moments.of(x).variance for x in pair) / len(pair[0]))
        gain = apart / np.sqrt(paired_differences(*pair).variance / len(pair[0]))
        print(f"  {label:28} {shown(paired, unit)}, {gain:.3g} times sharper than unpaired")


@mpl.rc_context(STYLE)
def draw(runs):
    """Mean square with its band, and the distributions of the settling time with theirs."""
    one = next(iter(runs.values()))
    duration = one.attrs["duration"]
    title = f"Finite-time (κ < 1) against asymptotic (κ = 1): {one.sizes['path']:,} paths each"
    note = (
        "double pendulum, corrected plant, noise as printed (Σ = 0.1); 95 % bands, "
        "where they are wider than the lines"
    )
    figure = page(5.6, title, note)
    square, settle = figure.subplots(2, 1)
    for (name, run), color in zip(runs.items(), (BLUE, ORANGE), strict=True):
        value, low, high = run["ote_mean_square"].values
        square.fill_between(run["time"], low, high, color=color, alpha=0.4, linewidth=0)
        square.plot(run["time"], value, color=color, label=name)
        times = settling(run)
        inside = times.time <= duration
        time = np.append(times.time[inside], duration)
        share, low, high = (np.append(x[inside], x[inside][-1:]) for x in times.share)
        settle.fill_between(time, low, high, color=color, alpha=0.4, linewidth=0, step="post")
        settle.plot(time, share, color=color, drawstyle="steps-post", label=name)
        if times.censored:
            text = f"{name}: {times.censored:,} of {run.sizes['path']:,} not by {duration:g} s"
            label_level(settle, share[-1], text, color)
    draw_level(square, BAND**2, f"({BAND:g} rad)²")
    square.set_yscale("log")
    square.set_ylabel("$E|z_1|^2$  [rad²]")
    settle.set_ylabel(f"share settled to {BAND:g} rad\nuntil the end (Kaplan-Meier)")
    settle.set_xlabel("time [s]")
    for ax, end in ((square, duration), (settle, START)):
        ax.set_xlim(0, end)
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    return figure


def main():
    """Run both, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer and shorter paths")
    parser.add_argument("--paths", type=int, help="number of paths of each law")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the figure")
    options = parser.parse_args()
    make_folder(options.out)
    paths = options.paths or (QUICK_PATHS if options.quick else PATHS)
    duration = QUICK_DURATION if options.quick else DURATION
    runs = {
        name: ensemble(closed_loop(case), paths, duration, tolerance=BAND)
        for name, case in CASES.items()
    }
    print(f"{paths:,} paths of {duration:g} s each, seed 0; late is from {duration / 2:g} s on")
    for name, run in runs.items():
        print_case(name, run)
    print_differences(*runs.values())
    record = {"paths": paths} | {name: measured(run) for name, run in runs.items()}
    write_whole(options.out / "ensemble.json", json.dumps(record, indent=1).encode())
    write_whole(options.out / "ensemble.png", rendered(draw(runs))["png"])


if __name__ == "__main__":
    main()
