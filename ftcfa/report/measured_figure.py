"""The figure of a measured vibration: the spectrum of each axis and its envelope."""

import matplotlib as mpl
from matplotlib.figure import Figure

from ftcfa.report.figures import BLUE, ORANGE, STYLE, literal, page, raised
from ftcfa.study.measured_spectrum import MeasuredVibration

PANEL = 2.4
"""Height of the axes of one channel [in]."""


@mpl.rc_context(STYLE)
def measured_figure(measured: MeasuredVibration) -> Figure:
    """Welch's estimate and the envelope of each axis, one above the other."""
    record, estimate = measured.record, measured.estimate
    count = len(record.axes)
    note = (
        f"{record.duration:.4g} s at {1 / record.step:.5g} Hz, Welch's estimate every "
        f"{estimate.frequencies[0]:.3g} Hz"
    )
    figure = page(0.9 + PANEL * count, f"Spectrum of {literal(record.notes[0])}", note)
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for k, (ax, name, unit) in enumerate(zip(axes, record.axes, record.units, strict=True)):
        envelope = measured.envelopes[k]
        ax.loglog(
            estimate.frequencies, estimate.densities[:, k], color=BLUE, lw=0.7, label="measured"
        )
        ax.loglog(
            envelope.frequencies, envelope.densities, color=ORANGE, marker="o", markersize=3,
            label=f"break points, {100 * measured.confidence:g} % limit",
        )  # fmt: skip
        ax.set_ylabel(f"{literal(name)} [({raised(unit)})²/Hz]")
        ax.set_title(f"{record.rms()[k]:.4g} {raised(unit)} rms", fontsize=9, loc="right")
    axes[0].legend(frameon=False, fontsize=8, loc="upper left")
    axes[-1].set_xlabel("frequency [Hz]")
    return figure
