"""Which command filter differentiates best, under what noise and at which period?

    python scripts/filters.py [--out FOLDER]

alpha = 5 sin 3t [rad/s] is sampled, with white noise on every sample. The script takes seconds; it
prints the error of the derivative that each filter gives, and writes the figure filters.png.
"""

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from ftcfa import ExplicitFilter, ImplicitFilter, ProperFilter, SecondOrderFilter
from ftcfa.arrays import Array
from ftcfa.control.filters import CommandFilter
from ftcfa.files import make_folder, write_whole
from ftcfa.report.figures import BLUE, DASHED, GREEN, GREY, INK, ORANGE, STYLE, page, rendered
from ftcfa.report.terminal import print_line, print_table

AMPLITUDE, FREQUENCY = 5.0, 3.0
SECOND, THIRD = AMPLITUDE * FREQUENCY**2, AMPLITUDE * FREQUENCY**3
"""Largest second and third derivative of alpha."""
LEVANT = {"r1": 1.5 * SECOND**0.5, "r2": 1.1 * SECOND}
FILTERS: dict[str, tuple[CommandFilter, str, str | tuple[int, tuple[int, int]]]] = {
    "explicit, the paper's gains": (ExplicitFilter(), ORANGE, "-"),
    "explicit, Levant's rule": (ExplicitFilter(**LEVANT), ORANGE, DASHED),
    "implicit, the paper's gains": (ImplicitFilter(), BLUE, "-"),
    "implicit, Levant's rule": (ImplicitFilter(**LEVANT), BLUE, DASHED),
    "second-order, 265 rad/s": (SecondOrderFilter(), GREY, "-"),
    "proper, default L": (ProperFilter(), GREEN, "-"),
    "proper, L of alpha": (ProperFilter(THIRD), GREEN, DASHED),
}
PERIODS = 1e-3 * np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
NOISES = np.array([0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1])
REPLICAS, DURATION = 64, 4.0


def error(chosen: CommandFilter, period: float, noise: float) -> float:
    """Rms error of the derivative over the second half [rad/s^2]."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, DURATION, period)
    alpha = AMPLITUDE * np.sin(FREQUENCY * t)
    rate = AMPLITUDE * FREQUENCY * np.cos(FREQUENCY * t)
    state, squares = chosen.init(np.zeros(REPLICAS)), []
    for k in range(len(t)):
        sample = alpha[k] + noise * rng.standard_normal(REPLICAS)
        _, derivative, state = chosen.step(state, sample, period)
        squares.append(np.mean((derivative - rate[k]) ** 2))
    return float(np.sqrt(np.mean(squares[len(t) // 2 :])))


@mpl.rc_context(STYLE)
def figure(steps: dict[str, Array], noises: dict[str, Array]) -> Figure:
    """Errors against the period without noise, and against the noise at 1 ms."""
    drawn = page(3.9, "Derivative of 5 sin 3t")
    left, right = drawn.subplots(1, 2, sharey=True)
    for name, (_, colour, dashes) in FILTERS.items():
        left.loglog(1e3 * PERIODS, steps[name], color=colour, linestyle=dashes, label=name)
        right.loglog(NOISES[1:], noises[name][1:], color=colour, linestyle=dashes)
    signal = AMPLITUDE * FREQUENCY / 2**0.5
    for ax in (left, right):
        ax.axhline(signal, color=INK, linewidth=0.8, linestyle=":")
    left.annotate("the derivative itself", (0.6, signal), (0, -10), textcoords="offset points")
    left.set_title("no noise")
    left.set_xlabel("period [ms]")
    left.set_ylabel("rms error [rad/s$^2$]")
    right.set_title("period 1 ms")
    right.set_xlabel("standard deviation of the noise on a sample [rad/s]")
    drawn.legend(loc="outside lower center", ncols=3, frameon=False)
    return drawn


def main() -> None:
    """Run all filters, print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the figure")
    options = parser.parse_args()
    make_folder(options.out)
    steps, noises = (
        {
            name: np.array([error(chosen, *case) for case in cases])
            for name, (chosen, _, _) in FILTERS.items()
        }
        for cases in ([(h, 0.0) for h in PERIODS], [(1e-3, noise) for noise in NOISES])
    )
    console = Console(highlight=False)
    for title, unit, values, errors in (
        ("no noise, by period", "ms", 1e3 * PERIODS, steps),
        ("period 1 ms, by noise on a sample", "rad/s", NOISES, noises),
    ):
        print_line(f"Rms error of the derivative [rad/s^2], {title}", console, "bold")
        heads = ["filter", *(f"{value:g}\n{unit}" for value in values)]
        rows = ([name, *(f"{value:.2g}" for value in row)] for name, row in errors.items())
        print_table(heads, rows, console, "fr")
        console.print()
    write_whole(options.out / "filters.png", rendered(figure(steps, noises))["png"])


if __name__ == "__main__":
    main()
