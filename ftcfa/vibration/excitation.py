"""Excitations xi: what shakes the robot, as the increment of its integral over a step."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.noise_input import NoiseInput

Convention = Literal["psd", "amplitude"]


class Excitation(Protocol):
    """xi of m channels, driven by standard normal deviates."""

    def amplitude(self, channels: int) -> Array:
        """Sigma with integral of xi over h = Sigma sqrt(h) normals, shape (m, m)."""
        ...


@dataclass(frozen=True, eq=False)
class WhiteNoise:
    """White noise of intensity varpi: E[xi(t) xi(s)^T] = varpi delta(t - s).

        xi dt = Sigma dW,   Sigma Sigma^T = varpi

    Its two-sided spectral density is varpi/(2 pi) per rad/s, as the paper says; the one-sided
    density per Hz is 2 varpi.

    Attributes:
        intensity: varpi, a number (times the identity), m numbers (a diagonal) or (m, m)
            positive semidefinite [unit of xi squared times s].
        convention: ``"psd"`` as above; ``"amplitude"`` takes Sigma = varpi, which is what the
            paper prints in (4).
    """

    intensity: npt.ArrayLike = 0.1
    convention: Convention = "psd"

    def __post_init__(self) -> None:
        if self.convention not in ("psd", "amplitude"):
            raise ParameterError(
                "WhiteNoise convention", repr(self.convention), '"psd" or "amplitude"'
            )
        varpi = self._varpi
        square = varpi.ndim == 2 and varpi.shape[0] == varpi.shape[1]
        if varpi.size == 0 or varpi.ndim > 2 or (varpi.ndim == 2 and not square):
            raise ShapeError("WhiteNoise intensity", f"shape {varpi.shape}", "(), (m,) or (m, m)")
        matrix = varpi if square else np.diag(np.atleast_1d(varpi))
        rounding = 1e-12 * np.abs(matrix).max()
        finite = np.all(np.isfinite(matrix))
        symmetric = finite and np.all(np.abs(matrix - matrix.T) <= rounding)
        if not symmetric or np.linalg.eigvalsh(matrix)[0] < -rounding:
            raise ParameterError(
                "WhiteNoise intensity", f"{varpi.tolist()}", "a positive semidefinite varpi"
            )

    @cached_property
    def _varpi(self) -> Array:
        try:
            return np.asarray(self.intensity, dtype=float)
        except (TypeError, ValueError) as error:
            raise ParameterError("WhiteNoise intensity", repr(self.intensity), "numbers") from error

    def amplitude(self, channels: int) -> Array:
        """Sigma: the symmetric root of varpi, or varpi itself, shape (m, m)."""
        varpi = self._varpi
        if varpi.ndim > 0 and varpi.shape[0] != channels:
            raise ShapeError(
                "WhiteNoise intensity", f"{varpi.shape[0]} channels", f"{channels} channels"
            )
        matrix = varpi if varpi.ndim == 2 else np.diag(np.broadcast_to(varpi, (channels,)))
        if self.convention == "amplitude":
            return matrix
        values, vectors = np.linalg.eigh(matrix)
        return (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T


@dataclass(frozen=True, eq=False)
class Vibration:
    """What shakes the robot: a noise input Lambda(q) and an excitation xi.

    Attributes:
        input: How the excitation loads the joints.
        excitation: The excitation of the input's channels.

    Raises:
        ShapeError: If input and excitation have different numbers of channels.
    """

    input: NoiseInput
    excitation: Excitation

    def __post_init__(self) -> None:
        if not hasattr(self.input, "matrix"):
            raise ParameterError("Vibration input", repr(self.input), "a noise input")
        if not hasattr(self.excitation, "amplitude"):
            raise ParameterError("Vibration excitation", repr(self.excitation), "an excitation")
        _ = self.sigma

    @cached_property
    def sigma(self) -> Array:
        """Sigma, shape (m, m)."""
        return self.excitation.amplitude(self.input.channels)

    @property
    def channels(self) -> int:
        """m, the number of standard normal deviates a step."""
        return self.input.channels

    def impulse(self, arm: Any, q: Array, step: float, normals: Array) -> Array:
        """Joint impulse Lambda(q) Sigma sqrt(h) n over one step, shape (n,) [N m s or N s].

        Args:
            arm: The true robot.
            q: Configuration at the start of the step (Ito), shape (n,) [rad or m].
            step: Its length h [s].
            normals: Standard normal deviates, shape (m,).
        """
        return self.input.matrix(arm, q) @ (self.sigma @ normals) * np.sqrt(step)
