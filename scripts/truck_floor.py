"""How well does the controller track on the floor of a truck?

    python scripts/truck_floor.py [--out FOLDER] [--quick]

The paper's double pendulum and Panda stand on the floor of a US highway truck (MIL-STD-810G, figure
514.6C-1, unverified in a primary source): longitudinal along x, transverse along y, vertical along
z, all at once and independent. The controller has the paper's gains and knows the nominal robot;
each path has a floor of its own and, where robots are uncertain, a robot of its own. The script
takes two minutes; it prints a table and writes truck-floor.png and truck-floor.json.
"""

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.text import Text

import ftcfa
from ftcfa.arrays import Array
from ftcfa.files import make_folder, write_whole
from ftcfa.loop.bounds import bounds_of
from ftcfa.report.figures import BLUE, INK, LIGHT, ORANGE, STYLE, draw_level, page, rendered
from ftcfa.report.terminal import print_line, print_table
from ftcfa.statistics.settling import below_for_good
from ftcfa.study.reproduction import BAND, GRAVITY, Q0, REFERENCE, V0
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

AXES = ("longitudinal", "transverse", "vertical")
TABLES = tuple(f"mil_std_810g_highway_truck_{axis}" for axis in AXES)
LINES, QUICK_LINES = 490, 49
"""Number of lines of a sum of sinusoids from 10 to 500 Hz: one every 1 Hz, or every 10 Hz."""
SUBSTEPS = 4
ROBOTS = ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1)
SHOWN = {"pendulum": "none", "Panda": "bias"}
"""The arms, and the compensation that the figure shows."""
LAW = {"none": "the paper's law", "bias": "nominal bias compensated"}
COLOURS = {
    ("truck", True): (ORANGE, "#F6D2BE"),
    ("truck", False): (BLUE, "#BBD7E8"),
    ("at rest", False): (INK, LIGHT),
}
"""Colours of median and band, by floor and whether robots are uncertain; the last is on top."""
HEADS = (
    "law", "floor", "robots", "rms OTE\nmrad", "settled\ns", "saturated\n%", "outside\npaths",
    "lost\npaths",
)  # fmt: skip
"""Heads of the tables."""
QUANTILES = (0.05, 0.5, 0.95)
RECORD_EVERY, POOLED = 5, 10
"""Number of samples of which one is recorded, and of recorded ones for a point of the figure."""
GLANCE = 0.2
"""Length of the close view of the floor [s]."""


@dataclass(frozen=True)
class Case:
    """One ensemble: which loop, on which floor, and whether its robots are uncertain."""

    arm: str
    compensation: str
    floor: str
    uncertain: bool = False


CASES = tuple(
    Case(arm, compensation, floor, uncertain)
    for arm in SHOWN
    for compensation in LAW
    for floor, uncertain in (
        ("at rest", False), ("truck", False), ("truck", True), ("lines", False),
    )
    if floor != "lines" or SHOWN[arm] == compensation
)  # fmt: skip


def closed_loop(case: Case, lines: int) -> ftcfa.ClosedLoop:
    """The paper's loop, or Panda about its home posture, on the floor of a case."""
    floors = {"truck": ftcfa.ShapedNoise(TABLES), "lines": ftcfa.RandomPhase(TABLES, lines)}
    if case.arm == "pendulum":
        arm = ftcfa.load_arm("double_pendulum", gravity=GRAVITY)
        reference, start = REFERENCE, {"q0": Q0, "v0": V0}
    else:
        arm, start = ftcfa.load_arm("panda"), {}
        reference = ftcfa.Sinusoid(amplitude=0.3, angular_frequency=1.0, offset=arm.home)
    return ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation=case.compensation),
        reference,
        ftcfa.Vibration(ftcfa.BaseAcceleration("xyz"), floors[case.floor])
        if case.floor in floors
        else None,
        substeps=SUBSTEPS,
        uncertainty=ROBOTS if case.uncertain else None,
        **start,
    )


def run(loop: ftcfa.ClosedLoop, paths: int, duration: float, seed: int) -> xr.Dataset:
    """Paths of a loop: ``ote`` [rad], ``effort`` and ``saturated`` over (path, time)."""
    ran = ftcfa.simulate_paths(
        loop, paths, duration, seed=seed, record_every=RECORD_EVERY, signals=["u_command"]
    )
    limit = xr.DataArray(loop.arm.effort_limit, dims="joint")
    return ran.assign(
        effort=(np.abs(ran.u) / limit).max("joint", skipna=False),
        saturated=(np.abs(ran.u_command) > limit).any("joint").where(np.isfinite(ran.ote)),
    )


def overloaded(loop: ftcfa.ClosedLoop, ran: xr.Dataset) -> Array:
    """Whether a robot could not follow the reference even on a floor at rest, shape (robots,).

    Inverse dynamics along the reference exceeds the torque limit.
    """
    robots = [loop.arm]
    if loop.uncertainty is not None:
        robots = [loop.arm.with_inertias(inertias) for inertias in ran["arm.inertias"].values]
    desired = loop.desired(ran.time.values[:: 4 * POOLED])
    return np.array([_demand(robot, desired) > 1.0 for robot in robots])


def _demand(robot: Any, desired: Any) -> float:
    """Largest torque that inverse dynamics needs along the reference, over its limit."""
    u = [
        robot.mass_matrix(q) @ a + robot.bias_force(q, v) for q, v, a in zip(*desired, strict=True)
    ]
    return float(np.max(np.abs(u) / robot.effort_limit))


def quantiles(values: Array, axis: int | tuple[int, ...] = 0) -> Array:
    """Quantiles of 5 %, 50 % and 95 %; a path that diverged counts as the largest."""
    ranked = np.where(np.isnan(values), np.inf, values)
    return np.quantile(ranked, QUANTILES, axis=axis, method="inverted_cdf")


def measured(case: Case, loop: ftcfa.ClosedLoop, ran: xr.Dataset) -> dict[str, Any]:
    """What the table and README say of a case; quantiles of 5, 50 and 95 % over the paths."""
    late = ran.ote.values[:, ran.sizes["time"] // 2 :]
    settled = np.array([below_for_good(ran.time.values, ote, BAND) for ote in ran.ote.values])
    outside = ~np.all(late < BAND, axis=1)
    error = np.abs(ran.q - ran.q_d).isel(time=-1).values
    return {
        **asdict(case),
        "rms_error": quantiles(1e3 * np.sqrt(np.mean(late**2, axis=1))).tolist(),
        "settled": quantiles(settled).tolist(),
        "saturated": quantiles(100 * ran.saturated.mean("time").values).tolist(),
        "outside": int(outside.sum()),
        "heavy": int(np.sum(outside & overloaded(loop, ran))),
        "lost": int(np.sum(~np.all(error <= bounds_of(loop.arm).error, axis=1))),
        "largest_error": float(np.nanmax(late)),
    }


def row(record: dict[str, Any]) -> list[str | Text]:
    """The texts of a row of the table."""
    heavy = record["heavy"]
    return [
        "paper's" if record["compensation"] == "none" else "+ bias",
        record["floor"],
        "uncertain" if record["uncertain"] else "nominal",
        _spread(record["rms_error"], ".2f"),
        _spread(record["settled"], ".2f"),
        _spread(record["saturated"], ".1f"),
        _above(f"{record['outside']}", f"{heavy} too heavy" if heavy else ""),
        f"{record['lost']}",
    ]


def _spread(values: list[float], spec: str) -> Text:
    """Median, and the other quantiles below it where they differ."""
    low, median, high = (format(q, spec).replace("inf", "never") for q in values)
    return _above(median, f"{low}-{high}" if low != high else "")


def _above(text: str, dim: str) -> Text:
    """A text above a dim one, which may be empty."""
    return Text.assemble(text, (f"\n{dim}" if dim else "", "dim"))


def print_tables(records: list[dict[str, Any]], paths: int, duration: float) -> None:
    """Print a table for each arm, and what the columns mean."""
    console = Console(highlight=False)
    for arm in SHOWN:
        print_line(f"{arm}, {paths} paths of {duration:g} s", console, "bold")
        shown = [row(record) for record in records if record["arm"] == arm]
        print_table(HEADS, shown, console, "lllr")
        console.print()
    console.print(
        "Medians over the paths; below them 5 and 95 %. rms OTE: of |q - q_d| in the second half "
        f"of the run. settled: |q - q_d| stays below {BAND:g} rad from then on. saturated: share "
        f"of time in which some joint has a torque command above its limit. outside: paths beyond "
        f"{BAND:g} rad in the second half; too heavy: of those, robots that could not follow the "
        "reference on a floor at rest. lost: paths of which a joint is a quarter turn from its "
        "reference at the end. lines: the same tables as sums of sinusoids (RandomPhase), "
        "which have nothing below 10 Hz.",
        style="dim",
    )


@mpl.rc_context(STYLE)
def figure(ensembles: dict[Case, xr.Dataset], seed: int) -> Figure:
    """The floor, and for each arm tracking errors and torques over time."""
    whole = page(6.9, "On the floor of a truck")
    floor, arms = whole.subfigures(2, 1, height_ratios=(1, 2.7))
    _draw_floor(floor.subplots(1, len(AXES), sharey=True), seed)
    panels = arms.subplots(2, 2, sharex=True, sharey="row")
    for column, (arm, compensation) in zip(panels.T, SHOWN.items(), strict=True):
        name = {"pendulum": "Double pendulum"}.get(arm, arm)
        column[0].set_title(f"{name}, {LAW[compensation]}")
        column[1].set_xlabel("time [s]")
        for (ground, uncertain), colours in COLOURS.items():
            ran = ensembles[Case(arm, compensation, ground, uncertain)]
            label = f"{ground}, robots {'uncertain' if uncertain else 'nominal'}"
            _draw_band(column[0], ran.ote, colours, label)
            _draw_band(column[1], ran.effort, colours, label)
    errors, efforts = panels
    for panel, level, text in ((errors, BAND, f"settled: below {BAND:g}"), (efforts, 1, "limit")):
        draw_level(panel[0], level)
        draw_level(panel[1], level, text)
    errors[0].set_yscale("log")
    errors[0].set_ylim(1e-6, 1.0)
    errors[0].set_ylabel("OTE  $|q - q_d|$  [rad]")
    efforts[0].set_ylim(0, 1.15)
    efforts[0].set_ylabel("largest $|u_i|/u_i^*$  [1]")
    efforts[0].set_xlim(0, float(ran.time[-1]))
    title = f"Median and, as a band, 5 to 95 % of {ran.sizes['path']} paths"
    handles = errors[0].get_legend_handles_labels()
    arms.legend(*handles, loc="outside lower center", ncols=3, frameon=False, title=title)
    return whole


def _draw_band(ax: Any, values: xr.DataArray, colours: tuple[str, str], label: str) -> None:
    """Draw median and band; each point pools several samples."""
    points = values.sizes["time"] // POOLED
    pooled = values.values[:, : points * POOLED].reshape(len(values), points, POOLED)
    time = values.time.values[: points * POOLED].reshape(points, POOLED).mean(axis=1)
    low, median, high = quantiles(pooled, (0, 2))
    ax.fill_between(time, low, high, color=colours[1], linewidth=0, zorder=2)
    ax.plot(time, median, color=colours[0], label=label, zorder=3)


def _draw_floor(panels: Any, seed: int) -> None:
    """Draw the floor's acceleration on path 0, the same for both arms."""
    step, floor = 1e-3 / SUBSTEPS, ftcfa.ShapedNoise(TABLES)
    a = ftcfa.realise(floor, len(AXES), GLANCE, step, seed=seed) / STANDARD_GRAVITY
    for k, (ax, axis, fit) in enumerate(zip(panels, AXES, floor.fits, strict=True)):
        level = fit.filter.rms()[0] / STANDARD_GRAVITY
        ax.plot(step * np.arange(len(a)), a[:, k], color=INK, linewidth=0.7)
        ax.set_title(f"{'xyz'[k]}, {axis}: {level:.2f} g rms")
        ax.set_xlabel("time [s]")
        ax.set_xticks([0, GLANCE / 2, GLANCE])
        ax.set_xlim(0, GLANCE)
    panels[0].set_ylabel("acceleration [g]")


def main() -> None:
    """Run all cases, print the tables, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the figure")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true", help="few short paths: seconds")
    options = parser.parse_args()
    make_folder(options.out)
    paths, duration, lines = (8, 1.0, QUICK_LINES) if options.quick else (200, 10.0, LINES)
    ensembles, records = {}, []
    for case in CASES:
        loop = closed_loop(case, lines)
        ensembles[case] = run(loop, paths, duration, options.seed)
        records.append(measured(case, loop, ensembles[case]))
    print_tables(records, paths, duration)
    record = {"paths": paths, "duration": duration, "cases": records}
    write_whole(options.out / "truck-floor.json", json.dumps(record, indent=1).encode())
    image = rendered(figure(ensembles, options.seed))["png"]
    write_whole(options.out / "truck-floor.png", image)


if __name__ == "__main__":
    main()
