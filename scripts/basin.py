"""From which starts does FTCF keep an arm, under each anti-saturation?

    python scripts/basin.py [--out FOLDER] [--quick]

On every arm of the catalogue all ways get the same starts, up to 1 rad (prismatic joints: a tenth
of the travel) off the home posture in every joint, the same torque limits, half of the arm's to all
of it, and the same noise. A path is lost if a joint is more than a quarter turn (a tenth of the
travel) from its reference at the end. The script takes ten minutes, prints a table with the upper
95 % bound of the excess over "none" (Clopper-Pearson for both shares of discordant pairs), and
draws the basin of the paper's pendulum. It writes basin.png and basin.json.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from rich.console import Console

import ftcfa
from ftcfa.arrays import Array
from ftcfa.files import make_folder, write_whole
from ftcfa.loop.bounds import QUARTER_TURN, TRAVEL, is_prismatic
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.report.figures import STYLE, page, rendered
from ftcfa.report.terminal import print_line, print_table
from ftcfa.statistics.proportions import paired_difference
from ftcfa.study.reproduction import Case, closed_loop

WAYS = ("none", "bounded", "paper")
OFF = 1.0
"""Largest distance of a start from the home posture [rad]."""
DURATION = 6.0
MORE_PATHS = {"double_pendulum_relative": 20_000, "baxter_left_arm": 20_000, "baxter": 40_000}
"""Paths of the arms that are lost most often, whose share is the least certain."""
PREMISE_PATHS = 16
Flags = npt.NDArray[np.bool_]
GRID = np.linspace(-3.0, 3.0, 25)
"""Starts of the pendulum, in both joints [rad]."""


def reach(arm: ftcfa.Arm, revolute: float) -> Array:
    """A distance for each joint: a number of radians, or a tenth of the travel, shape (n,)."""
    return np.where(is_prismatic(arm), TRAVEL * (arm.upper - arm.lower), revolute)


def losses(arm: ftcfa.Arm, paths: int) -> dict[str, Flags]:
    """Which paths are lost under each anti-saturation, shape (paths,)."""
    rng = np.random.default_rng(0)
    off = rng.uniform(-1.0, 1.0, (paths, arm.n)) * reach(arm, OFF)
    limits = arm.effort_limit * rng.uniform(0.5, 1.0, (paths, 1))
    starts = np.clip(arm.home + off, arm.lower, arm.upper)
    shaken = ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1))
    reference = ftcfa.Sinusoid(reach(arm, 0.3), offset=arm.home)
    lost = {}
    for way in WAYS:
        tried = ftcfa.FTCF(arm, compensation="bias", anti_saturation=way)  # type: ignore[arg-type]
        loop = ftcfa.ClosedLoop(arm, tried, reference, shaken)
        every = round(DURATION / loop.period)
        varied = {"q0": starts, "arm.effort_limit": limits}
        if way != "none":  # without rho the law has no use for the limits
            varied["controller.nominal.effort_limit"] = limits
        run = ftcfa.simulate_paths(loop, paths, DURATION, record_every=every, vary=varied)
        error = np.abs(run.q - run.q_d).isel(time=-1).values
        lost[way] = ~np.all(error <= reach(arm, QUARTER_TURN), axis=1)  # NaN, diverged, is lost
    return lost


def excess(lost: Flags, reference: Flags) -> tuple[float, float]:
    """Excess of one share of lost paths over another, and its upper 95 % bound [%]."""
    more, fewer = np.sum(lost & ~reference), np.sum(reference & ~lost)
    difference = paired_difference(int(more), int(fewer), len(lost), 0.9)  # 5 % at either end
    return 100 * float(difference.value), 100 * float(difference.high)


def measured(arm: str, paths: int) -> dict[str, Any]:
    """Shares of lost paths, and the excess over "none" with its upper bound [%]."""
    lost = losses(ftcfa.load_arm(arm), paths)
    return {
        "paths": paths,
        "lost": {way: 100 * float(np.mean(lost[way])) for way in WAYS},
        "excess": {way: excess(lost[way], lost["none"]) for way in WAYS[1:]},
    }


def print_losses(record: dict[str, dict[str, Any]]) -> None:
    """Print the shares of lost paths of every arm, and the excess over "none"."""
    rows = []
    for name, arm in record.items():
        shares = [f"{share:.1f}" for share in arm["lost"].values()]
        more = (f"{value:+.2f}, {bound:+.2f}" for value, bound in arm["excess"].values())
        rows.append([name, str(arm["paths"]), *shares, *more])
    console = Console(highlight=False)
    title = f"Lost paths [%] with white noise 0.1 (psd) on the base, {DURATION:g} s"
    print_line(title, console, "bold")
    over = "over none,\nat most"
    heads = ["arm", "paths", "none", "bounded", "paper", f"bounded\n{over}", f"paper\n{over}"]
    print_table(heads, rows, console, "lrrrrrr")
    console.print()


def premises(start: tuple[float, float] | None, way: str) -> dict[str, float]:
    """How far paths of the paper's pendulum go beyond what Lemma 7 and the network assume.

    Args:
        start: Initial position, at rest; None for the paper's start.
        way: ``"paper"`` or ``"bounded"``.
    """
    loop = closed_loop(Case(noise="psd"))
    loop = replace(loop, controller=law(loop.arm, way))
    if start is not None:
        loop = replace(loop, q0=start, v0=0.0)
    run = ftcfa.simulate_paths(loop, PREMISE_PATHS, 10.0, signals=["alpha", "abar", "rho"])
    error = np.abs(run.abar - run.alpha)
    return {
        "filter_error": float(error.max()),
        "late_filter_error": float(error.sel(time=slice(1.0, None)).max()),
        "largest_input": float(np.maximum(np.abs(run.q), np.abs(run.v)).max()),
        "largest_rho": float(np.abs(run.rho).max()),
        "largest_error": float(run.ote.max()),
    }


def law(arm: ftcfa.Arm, way: str) -> ftcfa.FTCF:
    """The paper's law with (11) as printed, or with the bounded gap."""
    return ftcfa.printed(ftcfa.FTCF(arm)) if way == "paper" else ftcfa.FTCF(arm)


def print_premises(record: dict[str, dict[str, float]]) -> None:
    """Print which premises hold from which start."""
    console = Console(highlight=False)
    title = f"The paper's pendulum, noise 0.1 (psd), {PREMISE_PATHS} paths of 10 s: largest values"
    print_line(title, console, "bold")
    heads = ["start and law", "|abar - alpha|\nrad/s", "the same\nafter 1 s", "|X|", "rho\nrad/s",
             "error\nrad"]  # fmt: skip
    rows = [[name, *(f"{x:.2g}" for x in row.values())] for name, row in record.items()]
    print_table(heads, rows, console, "lr")
    console.print()


def kept(way: str, paths: int) -> Array:
    """Share of paths of the paper's pendulum that stay, shape (starts of q2, starts of q1)."""
    loop = closed_loop(Case(noise="psd"))
    q2, q1 = np.meshgrid(GRID, GRID, indexing="ij")
    starts = np.repeat(np.stack([q1.ravel(), q2.ravel()], axis=1), paths, axis=0)
    loop = replace(loop, controller=law(loop.arm, way), v0=0.0)
    run = ftcfa.simulate_paths(loop, len(starts), 10.0, record_every=9999, vary={"q0": starts})
    error = np.abs(run.q - run.q_d).isel(time=-1).values
    stays = np.all(error <= QUARTER_TURN, axis=1)
    return np.mean(stays.reshape(len(GRID), len(GRID), paths), axis=2)


@mpl.rc_context(STYLE)
def figure(shares: dict[str, Array], paths: int) -> Figure:
    """Share of paths that stay over the start, printed against bounded."""
    note = f"{paths} paths of 10 s from rest at each start, noise 0.1 (psd); dot: the paper's start"
    drawn = page(4.3, "Share of paths that follow the reference", note)
    titles = {"paper": "(11) as printed", "bounded": "bounded gap"}
    edge = (GRID[1] - GRID[0]) / 2
    extent = (GRID[0] - edge, GRID[-1] + edge) * 2
    for ax, (way, share) in zip(drawn.subplots(1, 2, sharey=True), shares.items(), strict=True):
        image = ax.imshow(
            100 * share, origin="lower", extent=extent, vmin=0, vmax=100, cmap="cividis"
        )
        ax.plot(-0.1, 0.25, marker="o", color="white", mec="black", ms=5)
        ax.grid(visible=False)
        ax.set_title(titles[way])
        ax.set_xlabel("$q_1(0)$ [rad]")
    drawn.axes[0].set_ylabel("$q_2(0)$ [rad]")
    drawn.colorbar(image, ax=drawn.axes, label="paths kept [%]", shrink=0.9)
    return drawn


def main() -> None:
    """Print the table of all arms, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the figure")
    parser.add_argument("--quick", action="store_true", help="two arms, few paths: seconds")
    options = parser.parse_args()
    make_folder(options.out)
    quick = {"double_pendulum": 32, "panda": 32}
    arms = quick if options.quick else dict.fromkeys(catalogue(), 2000) | MORE_PATHS
    record = {name: measured(name, count) for name, count in arms.items()}
    print_losses(record)
    broken = {
        "the paper's start, (11) as printed": premises(None, "paper"),
        "(1, 1), (11) as printed": premises((1.0, 1.0), "paper"),
        "(1, 1), bounded": premises((1.0, 1.0), "bounded"),
    }
    print_premises(broken)
    written = {"arms": record, "premises": broken}
    write_whole(options.out / "basin.json", json.dumps(written, indent=1).encode())
    paths = 1 if options.quick else 16
    shares = {way: kept(way, paths) for way in ("paper", "bounded")}
    write_whole(options.out / "basin.png", rendered(figure(shares, paths))["png"])


if __name__ == "__main__":
    main()
