"""The figure of an ensemble: mean square, fan of errors, torque against its limit, settling."""

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from ftcfa.arrays import Array
from ftcfa.report.figures import BLUE, DASHED, INK, ORANGE, STYLE, draw_level, literal, page, raised
from ftcfa.study.outcomes import OUTCOMES, WORDS
from ftcfa.study.summary import settled_in_mean_square, settling

WIDTH, HEIGHT = 10.0, 7.0
"""Size of the page [in]."""
FILLS = (0.16, 0.36)
"""Opacity of the widest band of a fan, and of those within it."""
FLOOR = 0.5
"""Lower end of a logarithmic axis, relative to the smallest value on it."""
BEYOND = 1.25
"""End of the time axis of the settling, relative to the last settling time, if all settled."""
_KEY: dict[str, Any] = {
    "loc": "lower right", "bbox_to_anchor": (1.0, 0.99), "ncols": 3, "frameon": False,
    "fontsize": 8, "borderaxespad": 0.2, "columnspacing": 1.2, "handlelength": 1.5,
}  # fmt: skip
"""Options of the legends, on the line of the title."""


@mpl.rc_context(STYLE)
def ensemble_figure(dataset: xr.Dataset, effort_limit: Array, title: str) -> Figure:
    """An ensemble on one page of four panels; the effort limit is u*, shape (n,) [N m or N]."""
    figure = page(HEIGHT, title, _note(dataset), WIDTH)
    (square, fan), (torque, settle) = figure.subplots(2, 2)
    for ax in (square, fan, torque):
        ax.set_xlim(0, dataset.attrs["duration"] or None)
    _draw_mean_square(square, dataset)
    _draw_errors(fan, dataset)
    _draw_torque(torque, dataset, effort_limit)
    _draw_settling(settle, dataset)
    for ax in (square, fan, torque, settle):
        ax.set_xlabel("time [s]")
        ax.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    return figure


def _note(dataset: xr.Dataset) -> str:
    """What was run, below the heading."""
    attributes = dataset.attrs
    failed = [(attributes[word], label) for word, label in zip(WORDS, OUTCOMES, strict=True)][1:]
    outcome = ", ".join(f"{count:,} {label}" for count, label in failed if count) or "all kept"
    return (
        f"{dataset.sizes['path']:,} paths of seed {attributes['seed']}, {outcome}; "
        f"bands of {100 * attributes['confidence']:g} % confidence at each single time"
    )


def _draw_mean_square(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw E|z1|^2 with its band; that of all paths ends where the first path diverges."""
    time, epsilon = dataset["time"].values, float(dataset.attrs["tolerance"]) ** 2
    shown = [("ote_mean_square", BLUE, "all paths")]
    if dataset.attrs["diverged"]:
        shown.insert(0, ("ote_mean_square_not_diverged", ORANGE, "not diverged"))
    bottom = FLOOR * _smallest(dataset[shown[0][0]].values[0], epsilon)
    for name, color, label in shown:
        value, low, high = _above_zero(dataset[name].values)
        low = np.where(np.isfinite(value), np.nan_to_num(low, nan=bottom), np.nan)
        ax.fill_between(time, low, high, color=color, alpha=FILLS[1], linewidth=0)
        ax.plot(time, value, color=color, label=label)
    ax.set_title("mean-square error")
    ax.set_ylabel(f"$E|z_1|^2$  [{raised(dataset['ote_mean_square'].attrs['units'])}]")
    ax.set_yscale("log")
    ax.set_ylim(bottom, max(ax.get_ylim()[1], 4 * epsilon))
    draw_level(ax, epsilon, f"$\\epsilon$ = tolerance² = {epsilon:.3g}")
    _mark_reached(ax, settled_in_mean_square(dataset, epsilon))
    if len(shown) > 1:
        ax.legend(**_KEY)


def _mark_reached(ax: Axes, reached: float) -> None:
    """Mark the time of Definition 1 from which the upper bound stays below epsilon."""
    if not np.isfinite(reached):
        return
    if reached > 0:
        ax.axvline(reached, color=INK, linewidth=0.8, linestyle=DASHED)
    ax.annotate(
        f"upper bound below $\\epsilon$ from {reached:g} s on", (reached, 1.0), (5, -3),
        xycoords=("data", "axes fraction"), textcoords="offset points", va="top", fontsize=8,
        ha="right" if reached > ax.get_xlim()[1] / 2 else "left", in_layout=False,
    )  # fmt: skip


def _draw_errors(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw quantiles of the overall tracking error, and the tolerance."""
    tolerance, quantiles = dataset.attrs["tolerance"], dataset["ote_quantile"][0]
    _draw_fan(ax, quantiles.copy(data=_above_zero(quantiles.values)))
    ax.set_title("overall tracking error")
    ax.set_ylabel(f"OTE  $|q - q_d|$  [{raised(quantiles.attrs['units'])}]")
    ax.set_yscale("log")
    bottom, top = ax.get_ylim()
    ax.set_ylim(min(bottom, FLOOR * tolerance), max(top, 2 * tolerance))
    draw_level(ax, tolerance, f"tolerance {tolerance:g}")
    ax.legend(**_KEY)


def _draw_torque(ax: Axes, dataset: xr.Dataset, effort_limit: Array) -> None:
    """Draw quantiles of the torque of the busiest joint, and its limits."""
    joint = _busiest(dataset, effort_limit)
    one, limit = dataset["u_quantile"][0].isel(joint=joint), float(effort_limit[joint])
    unit = "N" if str(one["joint_type"].item()) == "prismatic" else "N m"
    _draw_fan(ax, one)
    ax.set_title(f"torque of {literal(one['joint'].item())}, quantiles as above")
    ax.set_ylabel(f"$u$  [{unit}]")
    if np.isfinite(limit):
        draw_level(ax, limit, f"$u^*$ = {limit:g} {unit}")
        draw_level(ax, -limit, f"$-${limit:g} {unit}", above=False)
        ax.set_ylim(-1.25 * limit, 1.25 * limit)


def _busiest(dataset: xr.Dataset, effort_limit: Array) -> int:
    """Index of the joint with the largest rms torque, in the mean over the paths.

    Relative to its limit, if all joints have one. Not by the peak torque: that of many joints
    reaches the limit.
    """
    rms = dataset["rms_torque"].values  # (paths, n)
    mean = np.where(np.isfinite(rms), rms, 0.0).mean(axis=0)
    return int(np.argmax(mean / effort_limit if np.isfinite(effort_limit).all() else mean))


def _draw_settling(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw Kaplan-Meier's distribution; paths that have not settled are censored at the end."""
    times, end = settling(dataset), float(dataset.attrs["duration"])
    if times.censored + times.diverged == 0:
        end = min(end, BEYOND * float(times.time[-1]) or end)
    inside = times.time < end
    time = np.append(times.time[inside], end)
    value, low, high = (
        np.append(share[inside], share[times.time <= end][-1:]) for share in times.share
    )
    ax.fill_between(time, low, high, color=BLUE, alpha=FILLS[1], step="post", linewidth=0)
    ax.plot(time, value, color=BLUE, drawstyle="steps-post")
    unit = dataset["ote_mean"].attrs["units"]
    ax.set_title(f"settled to within {dataset.attrs['tolerance']:g} {unit} until the end")
    ax.set_ylabel("share of paths")
    ax.set_xlim(0, end or None)
    ax.set_ylim(-0.03, 1.03)
    ax.yaxis.set_major_formatter(PercentFormatter(1.0))
    lines = [f"{times.settled:,} settled"]
    if times.censored:
        lines.append(f"{times.censored:,} not by {end:g} s (+, censored)")
        ax.plot(end, value[-1], "+", color=INK, markersize=9, clip_on=False, zorder=5)
    if times.diverged:
        lines.append(f"{times.diverged:,} diverged and never settle")
    high_up = value[-1] < 0.5
    ax.text(
        0.97, 0.93 if high_up else 0.07, "\n".join(lines), transform=ax.transAxes, ha="right",
        va="top" if high_up else "bottom", fontsize=8,
    )  # fmt: skip


def _draw_fan(ax: Axes, quantiles: xr.DataArray) -> None:
    """Draw bands between quantiles p and 1 - p, and the median, as long as they are finite."""
    levels = quantiles["quantile"].values
    time = quantiles["time"].values
    values = np.where(np.isfinite(quantiles.values), quantiles.values, np.nan)
    paired = [p for p in levels if p < 0.5 and np.any(np.isclose(levels, 1 - p))]
    for p, alpha in zip(paired, (FILLS[0], *[FILLS[1]] * len(paired)), strict=False):
        low, high = values[np.isclose(levels, p)][0], values[np.isclose(levels, 1 - p)][0]
        label = f"{100 * p:g} to {100 * (1 - p):g} %"
        ax.fill_between(time, low, high, color=BLUE, alpha=alpha, linewidth=0, label=label)
    middle = np.isclose(levels, 0.5)
    if middle.any():
        ax.plot(time, values[middle][0], color=BLUE, label="median")


def _above_zero(values: Array) -> Array:
    """Values that a logarithmic axis can show; the others become NaN."""
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def _smallest(values: Array, other: float) -> float:
    """The smallest of a number and of positive values."""
    return float(np.nanmin(np.append(_above_zero(values), other)))
