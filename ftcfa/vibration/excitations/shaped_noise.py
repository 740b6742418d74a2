"""Coloured noise from a specification: white noise through shaping filters, stationary at once."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated

import numpy as np
from scipy.linalg import block_diag

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields
from ftcfa.errors import ShapeError
from ftcfa.vibration.excitation import EACH, Excitation, Process
from ftcfa.vibration.spectra.filter_fit import FilterFit, fit_filter
from ftcfa.vibration.spectra.linear_filter import LinearFilter, SampledFilter
from ftcfa.vibration.spectra.road import Road
from ftcfa.vibration.spectra.spectrum import SAMPLES_PER_PERIOD, Spectrum, check_step
from ftcfa.vibration.spectra.standards import Specification, several, spectrum_of

Axis = Specification | LinearFilter | Road
"""What gives noise its colour: a specification to fit, a filter, or a road under a vehicle."""


def sources_of(subject: str, axes: Axis | Sequence[Axis]) -> tuple[Spectrum | LinearFilter, ...]:
    """The spectrum or filter of each axis.

    Raises:
        UnknownNameError, ParameterError: If an axis has neither.
    """
    return tuple(_source(axis) for axis in several(subject, axes))


def _source(axis: Axis) -> Spectrum | LinearFilter:
    if isinstance(axis, LinearFilter):
        return axis
    return axis.filter() if isinstance(axis, Road) else spectrum_of(axis)


@dataclass(frozen=True, eq=False)
class ShapedNoise(Excitation):
    """Gaussian noise with the spectra of linear filters, started stationary.

    Attributes:
        axes: What the channels are, independent of each other: the name of a table of
            `standards()`, a `Standard`, a `Spectrum` or a `Road`, a channel each; or a
            `LinearFilter`, whose outputs are as many channels. One alone needs no brackets.

    Raises:
        UnknownNameError: If there is no table of a name; it lists the known ones.
        ParameterError: If an axis is none of these.
    """

    axes: Annotated[Axis | Sequence[Axis], Check(sources_of)]

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "axes", several("ShapedNoise axes", self.axes))

    @classmethod
    def from_psd(cls, *axes: Axis) -> "ShapedNoise":
        """Independent noise on each axis: the same as ``ShapedNoise(axes)``."""
        return cls(axes)

    @cached_property
    def _sources(self) -> tuple[Spectrum | LinearFilter, ...]:
        """The spectrum or filter of each axis."""
        return sources_of("ShapedNoise axes", self.axes)

    @cached_property
    def filters(self) -> tuple[LinearFilter, ...]:
        """A filter an axis; their outputs side by side are the channels."""
        fits = iter(self.fits)
        return tuple(
            source if isinstance(source, LinearFilter) else next(fits).filter
            for source in self._sources
        )

    @cached_property
    def fits(self) -> tuple[FilterFit, ...]:
        """How the filters of specifications were fitted: print them to see how well.

        Warns:
            UserWarning: If one is not within the tolerance, or only where an edge may be off.
        """
        fits = tuple(_fitted(source) for source in self._sources if isinstance(source, Spectrum))
        for fit in fits:
            if not fit.within_tolerance:
                warnings.warn(str(fit), stacklevel=2)
        return fits

    def process(self, channels: int, step: float) -> "FilteredProcess":
        """See `Excitation.process`; the step must resolve the band of every fitted spectrum.

        Warns:
            UserWarning: If it is too long for a filter or a road; see `is_resolved`.
        """
        for source in self._sources:
            if isinstance(source, Spectrum):
                check_step(source, step)
            else:
                _check_filter(source, step)
        outputs = sum(shaping.outputs for shaping in self.filters)
        if outputs != channels:
            raise ShapeError("ShapedNoise", f"{outputs} channels", f"{channels} channels", EACH)
        return FilteredProcess(tuple(shaping.discretise(step) for shaping in self.filters))


class FilteredProcess(Process):
    """Shaping filters over steps of one length, exact in law at the steps' ends.

    Y = C x + D n,   x+ = A x + B n,   x_0 = root n,   W = E x,   U = F x
    """

    def __init__(self, filters: tuple[SampledFilter, ...]) -> None:
        self.A, self.B, self.C, self.D, self.E, self.F, self.root = (
            block_diag(*(getattr(sampled, name) for sampled in filters))
            for name in ("A", "B", "C", "D", "E", "F", "root")
        )
        self.initial_normals = self.root.shape[1]
        self.integrable = np.concatenate([sampled.integrable for sampled in filters])

    @property
    def normals(self) -> int:
        """Deviates that drive all filters."""
        return int(self.B.shape[1])

    def init(self, normals: Array) -> Array:
        """A stationary state, shape (states,)."""
        return self.root @ normals

    def advance(self, state: Array, normals: Array, row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """See `Process.advance`."""
        return self.C @ state + self.D @ normals, self.A @ state + self.B @ normals

    def obstacle(self, channel: int) -> str:
        """See `Process.obstacle`."""
        return "" if self.integrable[channel] else "noise whose density does not vanish like f^4"

    def integrals(self, state: Array, row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """See `Process.integrals`."""
        return self.E @ state, self.F @ state


def is_resolved(shaping: LinearFilter, step: float) -> bool:
    """Whether steps hold what a filter gives: their means keep 95 % of each output's variance.

    So much, sinc(1/8)^2, they keep of a tone that has eight steps a period.
    """
    held = np.diag(shaping.discretise(step).covariance(0)) / step**2
    return bool(np.all(held >= np.sinc(1.0 / SAMPLES_PER_PERIOD) ** 2 * shaping.rms() ** 2))


def _check_filter(shaping: LinearFilter, step: float) -> None:
    """Warn of a step too long for a filter, naming substeps, a power of two, that are not."""
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
