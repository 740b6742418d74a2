"""The figure of a comparison: the paths' quantiles, a row a loop and a panel a metric."""

import textwrap
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ftcfa.arrays import Array
from ftcfa.report.figures import BLUE, INK, LIGHT, STYLE, page

LINE, HEAD = 0.24, 1.2
"""Height of a loop's row, and of what surrounds the panels [in]."""
PANELS = {
    "settling_time": "settling time [s]",
    "late_rms_error": "late rms error [rad]",
    "effort": "rms torque / limit",
    "torque_rate": "torque rate [1/s]",
}
"""Metrics of the figure, and the titles of their panels."""
CROWDED = 40
"""Ratio above which a logarithmic axis labels powers of ten only."""
LOGARITHMIC = 20
"""Ratio of largest to smallest value above which an axis is logarithmic."""
WIDEST = 105
"""Characters of a line below the panels."""


@mpl.rc_context(STYLE)
def comparison_figure(dataset: xr.Dataset, title: str) -> Figure:
    """Median, quartiles and 5 to 95 % of the paths, a row a loop, a panel a metric."""
    names = [str(name) for name in dataset["loop"].values]
    figure = page(HEAD + 2 * (LINE * len(names) + 0.4), title)
    panels = figure.subplots(2, 2, sharey=True).ravel()
    for ax, (metric, label) in zip(panels, PANELS.items(), strict=True):
        _draw(ax, dataset["quantiles"].sel(metric=metric).values, names)
        duration = f", {dataset.attrs['duration']:g} if not settled"
        ax.set_title(label + (duration if metric == "settling_time" else ""))
    paths = dataset.sizes["path"]
    failed, diverged = paths - dataset["kept"].values, dataset["diverged"].values
    note = f"of {paths} paths each"
    for counts, word in ((failed, "failed"), (diverged, "diverged, beyond the right edge")):
        listed = ", ".join(f"{n}: {k}" for n, k in zip(names, counts, strict=True) if k)
        note += f"; {word}: {listed}" if listed else ""
    note += "" if failed.any() else "; all kept"
    words = textwrap.fill(f"median, quartiles and 5 to 95 % {note}", WIDEST)
    figure.supxlabel(words, fontsize=8, x=0.01, ha="left")
    return figure


def _draw(ax: Axes, quantiles: Array, names: Sequence[str]) -> None:
    """Draw the quantiles of a metric, shape (loops, 5); infinite ones lie beyond the right edge."""
    rows = np.arange(len(names))
    usable = quantiles[np.isfinite(quantiles) & (quantiles > 0)]
    largest = usable.max(initial=0.0)
    logarithmic = usable.size > 0 and largest > LOGARITHMIC * usable.min()
    shown = np.where(np.isfinite(quantiles), quantiles, 10 * max(1.0, largest))
    low, first, median, third, high = shown.T
    ax.hlines(rows, low, high, color=LIGHT, linewidth=2.0)
    ax.hlines(rows, first, third, color=BLUE, linewidth=4.0)
    ax.plot(median, rows, "o", color=INK, markersize=3.5)
    ax.set_yticks(rows, names)
    ax.set_ylim(len(names) - 0.5, -0.5)
    if logarithmic:
        ax.set_xscale("log")
        ax.set_xlim(0.7 * usable.min(), 1.4 * largest)
        steps = (1.0, 2.0, 5.0) if largest < CROWDED * usable.min() else (1.0,)
        ax.xaxis.set_major_locator(LogLocator(subs=steps))
        ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
    else:
        ax.set_xlim(0, 1.05 * (largest if usable.size else 1.0))
