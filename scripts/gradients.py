"""Would gradients tune faster than CMA-ES?

    python scripts/gradients.py [--quick] [--out FOLDER]

For six arms on the floor of a truck, ideal motors, uncertain robots: `ftcfa.tune` against Adam on
the logarithms of the gains, from the same suggested gains, for the same number of simulated paths.
The gradient is that of the objective on common random numbers, by central differences; a step is
charged as one with exact forward sensitivities would be at best, d + 1 simulations for d gains,
instead of the 2 d that the differences take. The objective is smooth where it can be: the mean
error late in the run, times 1 + 10 of the excess of the mean torque rate over that of the paper's
gains. Shown is the cost on fresh paths. It takes some ten minutes and writes gradients.json.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from tune_arms import DURATION, loop

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.report.terminal import print_line, print_table
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.start import suggested
from ftcfa.study.tuning.trial import Trial

FIGURES = Path(__file__).parent / "figures"
ARMS = ("double_pendulum", "panda", "ur5", "xarm7", "so101", "talos_left_arm")
GOAL = ftcfa.Objective(
    (ftcfa.Term("late_rms_error", 1.0, "mean"),), (ftcfa.Limit("rms_torque_rate"),), kept=0.99
)
PATHS, GENERATIONS, CANDIDATES, FRESH = 32, 25, 20, 256
DIFFERENCE, RATE = 0.01, 0.03
"""Of the finite differences, and the step of Adam, as shares of each logarithmic range."""
DECAY, SMALL = (0.9, 0.999), 1e-8
LOST, STIFF = 1e3, 10.0
"""Error of a lost candidate [rad], and the weight of what exceeds the limit."""


def smooth(trial: Trial, points: Any, paths: range) -> Any:
    """Costs of candidates as Adam takes them, shape (candidates,)."""
    score = trial.scored(points, paths)
    cost = np.nan_to_num(score.cost, posinf=LOST)
    return np.log(cost * (1.0 + STIFF * score.excess))


def adam(trial: Trial, start: Any, steps: int) -> tuple[Any, float]:
    """Adam's last point, and the largest relative difference between two finite differences."""
    x, m, v, doubt = start.copy(), 0.0, 0.0, []
    d = len(x)
    for step in range(1, steps + 1):
        paths = range(step * PATHS, (step + 1) * PATHS)
        shifts = np.vstack([np.eye(d), -np.eye(d)])
        points = np.clip(x + DIFFERENCE * shifts, 0.0, 1.0)
        values = smooth(trial, points, paths)
        width = np.diag(points[:d]) - np.diag(points[d:])
        gradient = (values[:d] - values[d:]) / np.maximum(width, SMALL)
        if step == 1:
            nearer = np.clip(x + DIFFERENCE / 2.0 * shifts, 0.0, 1.0)
            again = smooth(trial, nearer, paths)
            width = np.diag(nearer[:d]) - np.diag(nearer[d:])
            other = (again[:d] - again[d:]) / np.maximum(width, SMALL)
            doubt.append(np.linalg.norm(other - gradient) / np.linalg.norm(gradient))
        m = DECAY[0] * m + (1 - DECAY[0]) * gradient
        v = DECAY[1] * v + (1 - DECAY[1]) * gradient**2
        unbiased = m / (1 - DECAY[0] ** step), v / (1 - DECAY[1] ** step)
        x = np.clip(x - RATE * unbiased[0] / (np.sqrt(unbiased[1]) + SMALL), 0.0, 1.0)
    return x, float(doubt[0])


def case(robot: str, quick: bool) -> dict[str, Any]:
    """One arm: costs on fresh paths of the suggested gains, and of both searches."""
    it = loop(robot, "truck", "ideal")
    generations = 2 if quick else GENERATIONS
    found = ftcfa.tune(
        it, DURATION, GOAL, generations=generations, candidates=CANDIDATES, paths=PATHS
    )
    trial = Trial(it, Plan(DURATION), GOAL, Space(it))
    start = trial.space.point_of(suggested(it))
    raced = PATHS * CANDIDATES * (0.25 + 0.25 * 0.5 + 0.5 * 0.25) + PATHS  # a generation
    steps = max(1, round(generations * raced / (PATHS * (len(start) + 1))))
    last, doubt = adam(trial, start, steps)
    point = trial.space.unit_start if found.point is None else found.point
    fresh = range(2**40, 2**40 + FRESH)
    score = trial.scored(np.vstack([start, point, last]), fresh)
    names = ("suggested", "CMA-ES", "Adam")
    return {
        "arm": robot, "steps": steps, "generations": generations, "differences": doubt,
        "cost": dict(zip(names, map(number, score.cost), strict=True)),
        "excess": dict(zip(names, map(number, score.excess), strict=True)),
    }  # fmt: skip


def number(x: float) -> float | None:
    """A number for JSON."""
    return float(x) if np.isfinite(x) else None


def main() -> None:
    """Run all, print the table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one arm, little budget: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the record")
    options = parser.parse_args()
    make_folder(options.out)
    arms = ARMS[:1] if options.quick else ARMS
    record = [case(robot, options.quick) for robot in arms]
    console = Console(highlight=False, width=110)
    print_line(
        "mean rms error [mrad], and by how much the torque rate's limit is exceeded\n", console
    )
    names = ("suggested", "CMA-ES", "Adam")
    rows = [
        [it["arm"], *(cell(it, name) for name in names), f"{it['differences']:.2f}"]
        for it in record
    ]
    print_table(["arm", *names, "differences differ by"], rows, console)
    write_whole(options.out / "gradients.json", json.dumps(record, indent=1).encode())


def cell(it: dict[str, Any], name: str) -> str:
    """Cost and excess of one search."""
    cost, excess = it["cost"][name], it["excess"][name]
    if cost is None or excess is None:
        return "lost"
    return f"{1e3 * cost:.3g}" + (f" (+{excess:.0%})" if excess > 0 else "")


if __name__ == "__main__":
    main()
