"""Does Theorem 1's inequality hold along simulated paths, and how sharp are its bounds?

    python scripts/generator.py [--quick] [--out FOLDER]

The generator L V of the Lyapunov function (Definition 2) is taken by automatic differentiation of
the traced closed loop and evaluated along paths of the paper's study (noise as printed, theta =
eps = pi1 = 0): E[LV] against -Delta E[V^p] + Gamma, and the rms error against the promised bound
of |z1|. Then the time of the first entry into {V <= Vinf} against its bound, for two loops that
start outside; at the paper's gains the loop starts inside. The script prints a table and writes
generator.png and generator.json.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from rich.console import Console

from ftcfa import ClosedLoop, bounds
from ftcfa.files import make_folder, write_whole
from ftcfa.report.bounds_figure import bounds_figure
from ftcfa.report.figures import rendered
from ftcfa.report.terminal import print_table
from ftcfa.statistics.moments import Moments
from ftcfa.study.reproduction import FINITE_TIME, closed_loop
from ftcfa.theory.demonstrations import LINK_EPS, PI1, hanging_link, hanging_pendulum
from ftcfa.theory.premises import TheoremPaths, theorem_paths

PATHS, QUICK_PATHS = 128, 8
DURATION, QUICK_DURATION = 5.0, 0.3
"""Simulated time of the study's paths [s]."""
ENTRIES, QUICK_ENTRIES = 2000, 16
FIGURES = Path(__file__).parent / "figures"
ENTERING = 0.25
"""Simulated time of the other loops' paths [s]."""


def main() -> None:
    """Run the paths, print the table and write the figure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="few and short paths")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the figure")
    options = parser.parse_args()
    make_folder(options.out)
    paths, duration = (QUICK_PATHS, QUICK_DURATION) if options.quick else (PATHS, DURATION)
    loop = closed_loop(FINITE_TIME)
    study = theorem_paths(loop, bounds(loop), paths, duration)
    entries = QUICK_ENTRIES if options.quick else ENTRIES
    link = entering(hanging_link(), LINK_EPS, entries)
    pendulum = entering(hanging_pendulum(), 0.0, entries)
    print_study(study)
    print_entries({"link": link, "pendulum": pendulum})
    record = {
        "paths": entries,
        "promised_entry": link.bounds.first_entry,
        "entry": float(np.mean(link.entry)),
    }
    write_whole(options.out / "generator.json", json.dumps(record, indent=1).encode())
    notes = [
        f"The paper's study, {paths} paths: the inequality (30) in the mean",
        "The same paths: tracking error against its bound",
        f"A hanging link, {entries} paths: first entry into {{V ≤ Vinf}}",
    ]
    figure = bounds_figure(study, link, "Theorem 1 against simulated paths", notes)
    write_whole(options.out / "generator.png", rendered(figure)["png"])


def entering(loop: ClosedLoop, eps: float, paths: int) -> TheoremPaths:
    """Paths of a loop until all have entered."""
    return theorem_paths(loop, bounds(loop, eps=eps, pi1=PI1), paths, ENTERING)


def print_study(study: TheoremPaths) -> None:
    """Print whether (30) holds in the mean, and how far the bounds are from the measurements."""
    promised, needed = study.bounds, study.needed_Gamma.mean
    late = needed[study.time >= study.time[-1] / 2]
    rms = np.sqrt(np.mean(study.late_error**2))
    print(f"The paper's study, {len(study.z1)} paths of {study.time[-1]:g} s")
    print(
        f"- E[LV] <= -Delta E[V^p] + Gamma with Gamma = {promised.Gamma:.4g}; the paths need\n"
        f"  {needed.max():.4g} at most, and {late.max():.2g} in the last half.\n"
        f"- rms |z1| is {rms:.4f} rad in the last half; bound: {promised.ultimate_error:.3g}.\n"
        f"- phihat, unbounded by theta = 0, would need eps = {study.missing_eps.max():.4g}, "
        f"or theta = {study.values.needed_theta.max():.3g}.\n"
    )


def print_entries(rows: dict[str, TheoremPaths]) -> None:
    """Print the first entry, its bound and its premises, a row a loop."""
    heads = ("loop", "|z1| <=\nrad", "V0/Vinf", "E[entry] <=\ns", "measured\ns", "premises\nhold")
    cells = []
    for name, followed in rows.items():
        promised, entry = followed.bounds, Moments.of(followed.entry).skewness_corrected()
        half = float(entry.high - entry.low) / 2
        numbers = (promised.ultimate_error, promised.V0 / promised.Vinf, promised.first_entry)
        measured = f"{float(entry.value):.4f} ± {half:.4f}"
        hold = f"{100 * np.mean(followed.premises_hold):.1f} %"
        cells.append([name, *(f"{x:.3g}" for x in numbers), measured, hold])
    print_table(heads, cells, Console())
    print("premises: theta, eps and pi1 suffice until the first entry; the bound needs no more.")


if __name__ == "__main__":
    main()
