"""Figures of single paths: tracking, torque, errors compared, filters compared.

Built with Matplotlib's objects, never with pyplot: no window, no global state.
"""

import io
from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator

from ftcfa.arrays import Array
from ftcfa.errors import plain
from ftcfa.report.records import summary_file

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"
"""Colours of Okabe and Ito's palette, distinct for every kind of colour vision."""
INK, GREY, LIGHT = "#222222", "#6B6B6B", "#BBBBBB"
DASHED = (0, (4, 3))
WIDTH = 7.2
"""Width of every figure [in]."""
START = 2.0
"""Length of the close view of the beginning [s]."""
WINDOW = 0.05
"""Length of the close view of the filters [s]."""

STYLE: Any = {
    "font.family": ["DejaVu Sans", "sans-serif"],
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.2,
    "figure.dpi": 200,
    "svg.fonttype": "none",
    "svg.hashsalt": "ftcfa",
}


_KEY: dict[str, Any] = {"loc": "upper right", "ncols": 2, "frameon": False}
_AT_DATA: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
"""Options of a label at a height of the data, beside or inside the axes."""


def page(height: float, title: str = "", note: str = "", width: float = WIDTH) -> Figure:
    """An empty figure with a heading, and a note below it.

    Args:
        height: Its height [in].
        title: Heading.
        note: What is shown; the heading's empty second line leaves room for it.
        width: Its width [in].
    """
    figure = Figure(
        figsize=(width, height), layout=ConstrainedLayoutEngine(wspace=0.06, hspace=0.05)
    )
    if title:
        figure.suptitle(
            f"{title}\n" if note else title, x=0.01, ha="left", fontsize=11, fontweight="bold",
            parse_math=False,
        )  # fmt: skip
    figure.text(0.01, 1 - 0.28 / height, note, fontsize=8.5, color=GREY, va="top")
    return figure


def draw_level(
    ax: Axes, height: float, label: str = "", color: str = INK, above: bool = True
) -> None:
    """Draw a dashed line across the axes, with a label."""
    ax.axhline(height, color=color, linewidth=0.8, linestyle=DASHED, zorder=4)
    label_level(ax, height, label, color, above)


def label_level(ax: Axes, height: float, label: str, color: str = INK, above: bool = True) -> None:
    """Write a label at the right end of the axes, above or below a height."""
    ax.annotate(
        label, (0.99, height), (0, 4 if above else -4), ha="right", color=color, fontsize=8,
        va="bottom" if above else "top", in_layout=False, **_AT_DATA,
    )  # fmt: skip


def literal(name: str) -> str:
    """A name as it is written, where a figure would read mathematics between dollar signs."""
    return plain(name).replace("$", r"\$")


def raised(unit: str) -> str:
    """A unit with a raised 2 instead of ^2."""
    return unit.replace("^2", "²")


def rendered(figure: Figure) -> dict[str, bytes]:
    """A figure as PNG and as SVG, by suffix; the same figure gives the same bytes."""
    files = {}
    with mpl.rc_context(STYLE):
        for suffix, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=suffix, metadata=metadata)
            files[suffix] = buffer.getvalue()
    return files


def figure_files(name: str, figure: Figure, record: Mapping[str, Any]) -> dict[str, bytes]:
    """Files of a command, by name: PNG and SVG of its figure, and its record as summary.json."""
    images = {f"{name}.{suffix}": content for suffix, content in rendered(figure).items()}
    return {**images, "summary.json": summary_file(record)}


@mpl.rc_context(STYLE)
def tracking(path: xr.Dataset, title: str, note: str) -> Figure:
    """Position q against the reference q_d, joint by joint, from a result of `ftcfa.simulate`."""
    figure, axes = _joint_panels(path, title, note)
    for row, joint in zip(axes, path["joint"].values, strict=True):
        one = path.sel(joint=joint)
        for ax in row:
            ax.plot(one["time"], one["q_d"], color=LIGHT, linewidth=3.2, label="desired $q_d$")
            ax.plot(one["time"], one["q"], color=BLUE, label="measured $q$")
        row[0].set_ylabel(f"{literal(joint)} [{_unit(one, 'q')}]")
    figure.legend(*axes[0][0].get_legend_handles_labels(), **_KEY)
    return figure


@mpl.rc_context(STYLE)
def torque(path: xr.Dataset, limit: Array, title: str, note: str) -> Figure:
    """Applied torque u with its limits u*, shape (n,) [N m or N], joint by joint."""
    figure, axes = _joint_panels(path, title, note)
    for row, joint, bound in zip(axes, path["joint"].values, limit, strict=True):
        one = path.sel(joint=joint)
        for ax in row:
            ax.plot(one["time"], one["u"], color=BLUE, linewidth=0.8)
        _draw_limits(row, bound, _unit(one, "u"))
        row[0].set_ylabel(f"{literal(joint)} $u$ [{_unit(one, 'u')}]")
    return figure


@mpl.rc_context(STYLE)
def overall_error(paths: Mapping[str, xr.Dataset], band: float, title: str, note: str) -> Figure:
    """Overall tracking error on a linear and on a log axis, and the band of the settled [rad].

    Up to three results of `ftcfa.simulate` are drawn, by the labels of their controllers.
    """
    figure = page(5.4, title, note)
    linear, log = figure.subplots(2, 1, sharex=True)
    for (label, path), color in zip(paths.items(), (BLUE, ORANGE, GREEN), strict=False):
        time, ote = path["time"].values, path["ote"].values
        late = ote[len(ote) // 2 :]
        for ax in (linear, log):
            ax.plot(time, ote, color=color, linewidth=1.0)
            ax.set_xlim(0, time[-1])
            _label_right(ax, _level(late), label, color)
    for ax, label in ((linear, f"settled: below {band:g} rad"), (log, "")):
        draw_level(ax, band, label)
        ax.set_ylabel("OTE  $|q - q_d|$  [rad]")
    linear.set_ylim(bottom=0)
    log.set_yscale("log")
    log.set_xlabel("time [s]")
    log.xaxis.set_major_locator(_ticks())
    return figure


@mpl.rc_context(STYLE)
def filters(
    paths: Mapping[str, xr.Dataset], joint: str, limit: float, title: str, note: str
) -> Figure:
    """Error of the command filter, and the torque that follows from it, for one joint.

    Up to three Datasets with ``alpha`` and ``abar`` are drawn, by the filters' labels; the roughest
    comes first. The limit is the joint's u* [N m or N].
    """
    figure = page(5.0, title, note)
    axes = figure.subplots(2, 2, sharex="col", sharey="row", width_ratios=(1.6, 1))
    for (label, path), color in zip(paths.items(), (ORANGE, BLUE, GREEN), strict=False):
        one = path.sel(joint=joint)
        time, unit = one["time"].values, _unit(one, "u")
        error = np.abs(one["abar"].values - one["alpha"].values)
        for row, values in zip(axes, (error, one["u"].values), strict=True):
            row[0].plot(time, values, color=color, linewidth=0.5)
            row[1].plot(time, values, color=color, drawstyle="steps-post")
        _label_right(axes[0, 1], _level(error), label, color)
    _draw_limits(axes[1], limit, unit)
    begin = 0.75 * time[-1]
    axes[0, 0].set_xlim(0, time[-1])
    axes[0, 1].set_xlim(begin, begin + WINDOW)
    axes[0, 0].set_ylim(bottom=-0.01)  # a line at zero stands clear of the axis
    axes[0, 0].set_ylabel(f"{literal(joint)} filter error " r"$|\bar{\alpha} - \alpha|$ [rad/s]")
    axes[1, 0].set_ylabel(f"{literal(joint)} $u$ [{unit}]")
    _name_columns(axes, "whole run", f"{1e3 * WINDOW:.0f} ms of it")
    return figure


def _joint_panels(path: xr.Dataset, title: str, note: str) -> tuple[Figure, Any]:
    """A figure with a row of axes for each joint, the whole run and its beginning: shape (n, 2)."""
    n, end = path.sizes["joint"], float(path["time"][-1])
    figure = page(1.2 + 1.9 * n, title, note)
    axes = figure.subplots(n, 2, sharex="col", sharey="row", width_ratios=(1.8, 1), squeeze=False)
    axes[0, 0].set_xlim(0, end)
    axes[0, 1].set_xlim(0, min(START, end))
    _name_columns(axes, "whole run", "the beginning")
    return figure, axes


def _name_columns(axes: Any, *titles: str) -> None:
    """Write the titles above the columns and the time below."""
    for column, title in zip(axes.T, titles, strict=True):
        column[0].set_title(title)
        column[-1].set_xlabel("time [s]")
        column[-1].xaxis.set_major_locator(_ticks())


def _ticks() -> MaxNLocator:
    """Few and round ticks."""
    return MaxNLocator(4, steps=[1, 2, 5, 10])


def _level(values: Array) -> float:
    """Height of a curve's label: the root mean square of its finite values."""
    valid = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(valid**2))) if valid.size else np.nan


def _draw_limits(row: Any, bound: float, unit: str) -> None:
    """Draw u* and -u* as dashed lines, labelled at the right of the row."""
    for side, label in ((bound, f"$u^*$ = {bound:g} {unit}"), (-bound, f"$-${bound:g} {unit}")):
        for ax in row:
            draw_level(ax, side)
        _label_right(row[-1], side, label, INK)


def _label_right(ax: Axes, height: float, label: str, color: str) -> None:
    """Write a label to the right of the axes."""
    ax.annotate(label, (1, height), (4, 0), va="center", color=color, fontsize=8, **_AT_DATA)


def _unit(path: xr.Dataset, name: str) -> str:
    """Unit of q or u of one joint."""
    revolute = {"q": "rad", "u": "N m"}
    prismatic = {"q": "m", "u": "N"}
    return (prismatic if path["joint_type"].item() == "prismatic" else revolute)[name]
