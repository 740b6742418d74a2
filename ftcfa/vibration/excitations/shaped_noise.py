"""Coloured noise with given spectra: white noise through shaping filters, started stationary."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check
from ftcfa.vibration.excitation import Excitation, Process, check_channels
from ftcfa.vibration.spectra.filter_fit import FilterFit, fit_filter
from ftcfa.vibration.spectra.linear_filter import LinearFilter, SampledFilter, joined
from ftcfa.vibration.spectra.road import Road
from ftcfa.vibration.spectra.spectrum import SAMPLES_PER_PERIOD, Spectrum, check_step
from ftcfa.vibration.spectra.standards import SpectrumLike, several, spectrum_of

Axis = SpectrumLike | LinearFilter | Road
"""Source of a noise's spectrum: a spectrum to fit, a filter, or a road under a vehicle."""


def sources_of(subject: str, axes: Axis | Sequence[Axis]) -> tuple[Spectrum | LinearFilter, ...]:
    """The spectrum or filter of each axis; raises an FtcfaError if one has neither."""
    return tuple(_source(axis) for axis in several(subject, axes))


def _source(axis: Axis) -> Spectrum | LinearFilter:
    if isinstance(axis, LinearFilter):
        return axis
    return axis.filter() if isinstance(axis, Road) else spectrum_of(axis)


@dataclass(frozen=True, eq=False)
class ShapedNoise(Excitation):
    """Gaussian noise with the spectra of linear filters, started stationary.

    Attributes:
        axes: Independent sources of the channels. The name of a table of `standards()`, a
            `Standard`, a `Spectrum` or a `Road` gives one channel; a `LinearFilter` gives one for
            each of its outputs. A single source needs no brackets.

    Raises:
        UnknownNameError: If there is no table of a name; it lists the known ones.
        ParameterError: If an axis is none of these.
    """

    axes: Annotated[Axis | Sequence[Axis], Check(sources_of)]

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "axes", several("ShapedNoise axes", self.axes))

    @classmethod
    def from_psd(cls, *axes: Axis) -> "ShapedNoise":
        """Independent noise on each axis, the same as ``ShapedNoise(axes)``."""
        return cls(axes)

    @cached_property
    def _sources(self) -> tuple[Spectrum | LinearFilter, ...]:
        """The spectrum or filter of each axis."""
        return sources_of("ShapedNoise axes", self.axes)

    @cached_property
    def filters(self) -> tuple[LinearFilter, ...]:
        """Filters of the axes; their outputs side by side are the channels."""
        fits = iter(self.fits)
        return tuple(
            source if isinstance(source, LinearFilter) else next(fits).filter
            for source in self._sources
        )

    @cached_property
    def fits(self) -> tuple[FilterFit, ...]:
        """Fits of filters to spectra; the text of each says how good it is.

        Warns:
            UserWarning: If a fit is not within the tolerance, or only if edges may be off.
        """
        fits = tuple(_fitted(source) for source in self._sources if isinstance(source, Spectrum))
        for fit in fits:
            if not fit.within_tolerance:
                warnings.warn(str(fit), stacklevel=2)
        return fits

    def process(self, channels: int, step: float) -> "FilteredProcess":
        """See `Excitation.process`; the step must resolve the band of every fitted spectrum.

        Warns:
            UserWarning: If the step is too long for a filter or a road; see `is_resolved`.
        """
        for source in self._sources:
            if isinstance(source, Spectrum):
                check_step(source.band[1], step)
            else:
                _check_filter(source, step)
        check_channels("ShapedNoise", sum(one.outputs for one in self.filters), channels)
        return FilteredProcess(joined([shaping.discretise(step) for shaping in self.filters]))


@dataclass(frozen=True, eq=False)
class FilteredProcess(Process):
    """A shaping filter over steps of one length, exact in law at the ends of the steps.

    Attributes:
        filter: The filter; see `SampledFilter` for its equations.
    """

    filter: SampledFilter

    @property
    def normals(self) -> int:
        """Number of deviates that drive the filter."""
        return self.filter.normals

    @cached_property
    def initial_normals(self) -> int:
        """Number of deviates that make a stationary state."""
        return int(self.filter.root.shape[1])

    def init(self, normals: Traceable) -> Traceable:
        """A stationary state, shape (states,)."""
        return self.filter.root @ normals

    def advance(
        self, state: Traceable, normals: Traceable, row: Traceable
    ) -> tuple[Traceable, Traceable]:
        """See `Process.advance`."""
        it = self.filter
        return it.C @ state + it.D @ normals, it.A @ state + it.B @ normals

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`."""
        integrable = self.filter.integrable[channel]
        return "" if integrable else "noise whose density does not vanish like f^4"

    def integrals(self, state: Traceable, row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        return self.filter.E @ state, self.filter.F @ state


def is_resolved(shaping: LinearFilter, step: float) -> bool:
    """Whether the means over steps keep 95 % of the variance of each output of a filter.

    The means keep this share, sinc(1/8)^2, of a tone with eight steps in a period.
    """
    held = np.diag(shaping.discretise(step).covariance(0)) / step**2
    return bool(np.all(held >= np.sinc(1.0 / SAMPLES_PER_PERIOD) ** 2 * shaping.rms() ** 2))


def _check_filter(shaping: LinearFilter, step: float) -> None:
    """Warn if a step is too long for a filter, and name sufficient substeps, a power of two."""
    substeps = 1
    while not is_resolved(shaping, step / substeps):
        substeps *= 2
    if substeps > 1:
        warnings.warn(
            f"integration step: {1e3 * step:.4g} ms, within which a filter's output changes; take "
            f"substeps={substeps} of the period {1e3 * step:.4g} ms, or a shorter period",
            stacklevel=3,
        )


def _fitted(spectrum: Spectrum) -> FilterFit:
    return _fitted_once(tuple(spectrum.frequencies.tolist()), tuple(spectrum.densities.tolist()))


@cache
def _fitted_once(frequencies: tuple[float, ...], densities: tuple[float, ...]) -> FilterFit:
    return fit_filter(Spectrum(np.array(frequencies), np.array(densities)))
