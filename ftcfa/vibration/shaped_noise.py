"""Coloured noise from a specification: white noise through shaping filters, stationary at once."""

from dataclasses import dataclass

from scipy.linalg import block_diag

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.fitting import FilterFit, fit_filter
from ftcfa.vibration.shaping import LinearFilter, SampledFilter
from ftcfa.vibration.spectrum import Spectrum, check_step
from ftcfa.vibration.standards import Standard, standard

Specification = str | Standard | Spectrum
"""A specification: the name of a standard's table, the table, or a spectrum."""


@dataclass(frozen=True, eq=False)
class ShapedNoise(Excitation):
    """Gaussian noise with the spectra of linear filters, started stationary.

    Attributes:
        filters: One filter or more, whose outputs side by side are the channels.
        fits: How the filters were fitted, if they were: print them to see how well.
    """

    filters: tuple[LinearFilter, ...]
    fits: tuple[FilterFit, ...] = ()

    def __post_init__(self) -> None:
        if not self.filters or not all(isinstance(f, LinearFilter) for f in self.filters):
            raise ParameterError("ShapedNoise filters", repr(self.filters), "LinearFilters")

    @classmethod
    def from_psd(cls, *axes: Specification) -> "ShapedNoise":
        """Independent noise on each axis with the given acceleration spectra.

        Args:
            axes: A specification for each channel: the name of a table of `standards()`, a
                `Standard`, or a `Spectrum`.

        Raises:
            UnknownNameError: If there is no table of a name; it lists the known ones.
        """
        fits = tuple(fit_filter(_spectrum(axis)) for axis in axes)
        return cls(tuple(fit.filter for fit in fits), fits)

    def process(self, channels: int, step: float) -> "FilteredProcess":
        """See `Excitation.process`; the step must resolve the band of every fitted spectrum."""
        outputs = sum(shaping.outputs for shaping in self.filters)
        if outputs != channels:
            raise ShapeError("ShapedNoise", f"{outputs} channels", f"{channels} channels")
        for fit in self.fits:
            check_step(fit.spectrum, step)
        return FilteredProcess(tuple(shaping.discretise(step) for shaping in self.filters))


class FilteredProcess(Process):
    """Shaping filters over steps of one length, exact in law at the steps' ends.

    Y = C x + D n,   x+ = A x + B n,   x_0 = root n
    """

    def __init__(self, filters: tuple[SampledFilter, ...]) -> None:
        self.A, self.B, self.C, self.D, self.root = (
            block_diag(*(getattr(sampled, name) for sampled in filters))
            for name in ("A", "B", "C", "D", "root")
        )
        self.initial_normals = self.root.shape[1]

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


def _spectrum(specification: Specification) -> Spectrum:
    if isinstance(specification, str):
        specification = standard(specification)
    if isinstance(specification, Standard):
        return specification.spectrum
    if isinstance(specification, Spectrum):
        return specification
    raise ParameterError(
        "vibration specification", repr(specification), "a standard's name or a Spectrum"
    )
