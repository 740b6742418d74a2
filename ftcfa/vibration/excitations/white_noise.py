"""White noise of a given intensity, in the two conventions of the paper."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, about, numbers
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.parts import Parameters, number_fields
from ftcfa.vibration.excitation import Excitation, Process, check_channels

Convention = Literal["psd", "amplitude"]


def check_intensity(subject: str, intensity: npt.ArrayLike) -> None:
    """Raise a FtcfaError unless an intensity is a positive semidefinite varpi."""
    varpi = numbers(subject, intensity)
    square = varpi.ndim == 2 and varpi.shape[0] == varpi.shape[1]
    if varpi.size == 0 or not (square or varpi.ndim < 2):
        raise ShapeError(subject, f"shape {varpi.shape}", "(), (m,) or (m, m)")
    matrix = varpi if square else np.diag(np.atleast_1d(varpi))
    rounding = 1e-12 * np.abs(matrix).max()
    finite = np.all(np.isfinite(matrix))
    symmetric = finite and np.all(np.abs(matrix - matrix.T) <= rounding)
    if not symmetric or np.linalg.eigvalsh(matrix)[0] < -rounding:
        raise ParameterError(subject, f"{varpi.tolist()}", "a positive semidefinite varpi")


@dataclass(frozen=True, eq=False)
class WhiteNoise(Excitation):
    """White noise of intensity varpi: E[xi(t) xi(s)^T] = varpi delta(t - s).

        xi dt = Sigma dW,   Sigma Sigma^T = varpi

    Its two-sided spectral density is varpi/(2 pi) per rad/s, as the paper states; its one-sided
    density per Hz is 2 varpi.

    Attributes:
        intensity: varpi, a number (times the identity), m numbers (a diagonal) or (m, m)
            positive semidefinite [unit of xi squared times s].
        convention: ``"psd"`` as above; ``"amplitude"`` takes Sigma = varpi, as the paper prints
            in (4).
    """

    intensity: Annotated[npt.ArrayLike, Check(check_intensity)] = 0.1
    convention: Convention = "psd"

    varies: ClassVar[Parameters] = number_fields("intensity")

    @cached_property
    def _varpi(self) -> Array:
        return numbers("WhiteNoise intensity", self.intensity)

    def amplitude(self, channels: int) -> Array:
        """Sigma, the symmetric root of varpi or varpi itself, shape (m, m)."""
        varpi = self._varpi
        if varpi.ndim > 0:
            with about("intensity"):
                check_channels("WhiteNoise intensity", len(varpi), channels)
        matrix = varpi if varpi.ndim == 2 else np.diag(np.broadcast_to(varpi, (channels,)))
        if self.convention == "amplitude":
            return matrix
        values, vectors = np.linalg.eigh(matrix)
        return (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T

    def process(self, channels: int, step: float) -> "WhiteProcess":
        """See `Excitation.process`."""
        return WhiteProcess(self.amplitude(channels), step)


@dataclass(frozen=True, eq=False)
class WhiteProcess(Process):
    """White noise over steps: Y = Sigma sqrt(h) n.

    Attributes:
        sigma: Shape (m, m).
        step: h [s].
    """

    sigma: Array
    step: float

    varies: ClassVar[Parameters] = number_fields("sigma")

    @property
    def normals(self) -> int:
        """One deviate for each channel in each step."""
        return len(self.sigma)

    def advance(
        self, state: tuple[()], normals: Traceable, row: Traceable
    ) -> tuple[Traceable, tuple[()]]:
        """See `Process.advance`."""
        return self.sigma @ normals * np.sqrt(self.step), state

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`."""
        return "white noise, whose integral is a random walk"
