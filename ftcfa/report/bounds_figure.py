"""The figure of Theorem 1 against simulated paths."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ftcfa.report.figures import (
    BLUE,
    DASHED,
    GREY,
    LIGHT,
    ORANGE,
    STYLE,
    draw_level,
    label_level,
    page,
)
from ftcfa.theory.premises import TheoremPaths

LINEAR = 0.1
"""Absolute value of LV below which its axis is linear [1/s]."""


@mpl.rc_context(STYLE)
def bounds_figure(
    study: TheoremPaths, entering: TheoremPaths, title: str, notes: list[str]
) -> Figure:
    """Theorem 1 against simulated paths: its inequality, its error bound, its first-entry time.

    Args:
        study: Paths of a loop, for the first two panels.
        entering: Paths of a loop that starts outside {V <= Vinf}, for the third.
        title: Heading.
        notes: What each panel shows, three lines.
    """
    figure = page(8.4, title)
    axes = figure.subplots(3, 1)
    for ax, note in zip(axes, notes, strict=True):
        ax.set_title(note, fontsize=8.5, color=GREY)
        ax.set_xlabel("time [s]")
    _draw_inequality(axes[0], study)
    _draw_promise(axes[1], study)
    _draw_entries(axes[2], entering)
    return figure


def _draw_inequality(ax: Axes, study: TheoremPaths) -> None:
    """Draw E[LV] below -Delta E[V^p] + Gamma."""
    promised, values = study.bounds, study.values
    LV = np.mean(values.LV, axis=0)
    decay = -promised.Delta * np.mean(values.V**promised.p, axis=0)
    ax.plot(study.time, decay + promised.Gamma, color=ORANGE)
    ax.plot(study.time, LV, color=BLUE, linewidth=0.8)
    ax.set_yscale("symlog", linthresh=LINEAR)
    ax.set_ylabel("rate of $V$")
    ax.set_xlim(0, study.time[-1])
    label_level(ax, promised.Gamma, r"$-\Delta\, E V^p + \Gamma$", ORANGE, above=False)
    label_level(ax, 0.0, "$E[LV]$", BLUE)


def _draw_promise(ax: Axes, study: TheoremPaths) -> None:
    """Draw the rms error against the bounds of |z1|."""
    promised = study.bounds
    ax.plot(study.time, np.sqrt(np.mean(study.z1**2, axis=0)), color=BLUE)
    ax.set_yscale("log")
    ax.set_xlim(0, study.time[-1])
    ax.set_ylabel("$|z_1|$ [rad]")
    without = f"promised without the {promised.largest_term} term"
    lines = ((promised.ultimate_error, "promised"), (promised.error_without_largest_term, without))
    for height, label in lines:
        draw_level(ax, height, f"{label}: {height:.3g} rad", ORANGE)
    rms = float(np.sqrt(np.mean(study.late_error**2)))
    label_level(ax, 2 * rms, f"rms of the paths, {rms:.2g} rad", BLUE)


def _draw_entries(ax: Axes, entering: TheoremPaths) -> None:
    """Draw the distribution of the first entry, its mean and the bound of the mean."""
    entry = np.sort(entering.entry[np.isfinite(entering.entry)])
    share = np.arange(1, len(entry) + 1) / len(entering.entry)
    ax.step(entry, share, where="post", color=BLUE)
    ax.axhline(1.0, color=LIGHT, linewidth=0.8)
    ax.set_xscale("log")
    ax.set_xlim(0.5 * entry[0], 1.3 * entering.bounds.first_entry)
    ax.set_ylim(0, 1.08)
    ax.set_ylabel("share that has entered")
    marks = (
        ("mean", float(np.mean(entry)), BLUE, "left"),
        ("bound", entering.bounds.first_entry, ORANGE, "right"),
    )
    for name, place, color, side in marks:
        ax.axvline(place, color=color, linestyle=DASHED, linewidth=1.0)
        ax.annotate(f" {name} {place:.3g} s ", (place, 0.5), color=color, fontsize=8, ha=side)
