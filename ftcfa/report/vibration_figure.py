"""The figure of vibration standards: what is specified, fitted and realised."""

import textwrap
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ftcfa.arrays import Array
from ftcfa.report.figures import BLUE, GREEN, GREY, INK, LIGHT, ORANGE, STYLE, page
from ftcfa.report.vibration import provenance_lines
from ftcfa.study.realised_spectrum import RealisedStandard
from ftcfa.vibration.spectra.section_fit import DB, DB_TOLERANCE
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

PANEL, HEAD = 2.9, 0.25
"""Height of a panel, and of the space above all panels [in]."""
NOTE_WIDTH = 100
"""Length of the lines of a provenance [characters]."""
NOTE_LINE, TITLE_PAD = 11.0, 6.0
"""Height of such a line, and the space around the lines [points]."""
BESIDE, ABOVE, BELOW = 1.6, 3.0, 6.0
"""Factors that widen the axes: on the frequencies, the highest and the lowest density."""
CROWDED = 1000
"""Ratio of the band's ends above which only the decades are labelled."""
GRID = 1000
"""Number of frequencies at which a filter's density is drawn."""


@mpl.rc_context(STYLE)
def vibration_figure(realised: Sequence[RealisedStandard]) -> Figure:
    """Standards, fitted filters, and Welch's estimates of realisations, a panel each."""
    figure = page(HEAD + PANEL * len(realised))
    panels = figure.subplots(len(realised), 1, squeeze=False)[:, 0]
    for ax, one in zip(panels, realised, strict=True):
        _head(ax, one)
        _draw(ax, one)
        _scale(ax, one)
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), frameon=False, fontsize=8)
    return figure


def _head(ax: Axes, one: RealisedStandard) -> None:
    """Write name and provenance of a standard above its panel, without mathematical text."""
    lines = [
        line
        for text in provenance_lines(one.standard.source, one.standard.verified)
        for line in textwrap.wrap(text, NOTE_WIDTH)
    ]
    above = TITLE_PAD + NOTE_LINE * len(lines)
    ax.set_title(one.standard.name, fontsize=10, fontweight="bold", pad=above, parse_math=False)
    ax.annotate(
        "\n".join(lines), (0, 1), (0, TITLE_PAD), xycoords="axes fraction",
        textcoords="offset points", fontsize=8, color=GREY, va="bottom", parse_math=False,
    )  # fmt: skip


def _draw(ax: Axes, one: RealisedStandard) -> None:
    """Draw the curves, each with its overall level; the table lies over the estimates."""
    table, shaped, tones = one.standard.spectrum, one.shaped, one.tones
    level = float(one.fit.filter.rms()[0])
    error = DB * np.log1p(shaped.standard_error)
    ax.plot(
        table.frequencies, _in_g(table.densities), color=INK, linewidth=1.0, zorder=5,
        marker="o", markersize=3.5, label=f"specified\n{_g_rms(table.rms())}",
    )  # fmt: skip
    f = np.union1d(table.frequencies, np.geomspace(*table.band, GRID))
    S, factor = _in_g(table.density(f)), np.exp(DB_TOLERANCE / DB)
    tolerance = f"±{DB_TOLERANCE:g} dB"
    ax.fill_between(f, S / factor, S * factor, color=LIGHT, alpha=0.5, lw=0, label=tolerance)
    wide = np.geomspace(table.band[0] / BESIDE, table.band[1] * BESIDE, GRID)
    ax.plot(
        wide, _in_g(one.fit.filter.density(wide)[:, 0]), color=ORANGE, zorder=4,
        label=f"fitted filter, order {one.fit.filter.order}\n{_g_rms(level)}",
    )  # fmt: skip
    ax.plot(
        shaped.frequencies, _in_g(shaped.densities[:, 0]), color=BLUE, linewidth=0.7, zorder=3,
        label=f"ShapedNoise, {one.duration:.0f} s\n{_g_rms(shaped.rms[0])}\n"
        f"Welch, every {shaped.frequencies[0]:.3g} Hz,\nstandard error {error:.1f} dB",
    )  # fmt: skip
    ax.plot(
        tones.frequencies, _in_g(tones.densities[:, 0]), color=GREEN, linewidth=1.0, alpha=0.6,
        label=f"RandomPhase, {one.lines} lines\n{_g_rms(tones.rms[0])}",
    )  # fmt: skip


def _scale(ax: Axes, one: RealisedStandard) -> None:
    """Make the axes logarithmic around the table, with plain numbers of hertz."""
    low, high = one.standard.spectrum.band
    S = _in_g(one.standard.spectrum.densities)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(low / BESIDE, high * BESIDE)
    ax.set_ylim(S.min() / BELOW, S.max() * ABOVE)
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < CROWDED * low else (1,)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("acceleration density [g²/Hz]")


def _in_g(densities: Array) -> Array:
    """Densities in g^2/Hz, from (m/s^2)^2/Hz."""
    return densities / STANDARD_GRAVITY**2


def _g_rms(level: float) -> str:
    """Text of an overall level in g, from m/s^2."""
    return f"{level / STANDARD_GRAVITY:#.4g} g rms"
