"""Excitations xi: what shakes the robot, as the increment of its integral over a step."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError

EACH = "one for each channel of the noise input, or choose fewer of its axes"
"""Remedy where there are not as many channels as the input has."""
Convention = Literal["psd", "amplitude"]


class Process(ABC):
    """An excitation over integration steps of one length: what the loop runs.

        Y_k, x_{k+1} = advance(x_k, n_k, row_k),      Y_k: integral of xi over step k

    Attributes:
        initial_normals: Standard normal deviates that the initial state takes.
        rows: Numbers that all paths share, a row a step, shape (R, columns); after the last row
            comes the first.
        random_start: Whether each path begins at a row of its own.
    """

    initial_normals: int = 0
    rows: Array = np.zeros((1, 0))
    random_start: bool = False

    @property
    @abstractmethod
    def normals(self) -> int:
        """Standard normal deviates a step."""

    def init(self, normals: Array) -> Any:  # noqa: ARG002
        """State before the first step: arrays in tuples, from ``initial_normals`` deviates."""
        return ()

    @abstractmethod
    def advance(self, state: Any, normals: Array, row: Array) -> tuple[Array, Any]:
        """One step: integral of xi over it, shape (m,), and the new state.

        Args:
            state: State at its start.
            normals: Standard normal deviates, shape (normals,).
            row: The step's row, shape (columns,).
        """

    def obstacle(self, channel: int) -> str:  # noqa: ARG002
        """Why a channel has not both `integrals`, and so cannot turn a base; "" if it has."""
        return "an excitation that gives no integrals"

    def integrals(self, state: Any, row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """The stationary integrals W of xi and U of W at the start of a step, shape (m,) each.

            W_{k+1} = W_k + Y_k,   U_{k+1} = U_k + integral of W over step k

        Both are of mean zero. They have no meaning in channels with an `obstacle`; a process
        whose channels all have one need not give them.

        Args:
            state: State there.
            row: The step's row.
        """
        return np.zeros(1), np.zeros(1)


class Excitation(ABC):
    """What shakes: a description from which a `Process` is made for a step length."""

    @abstractmethod
    def process(self, channels: int, step: float) -> Process:
        """The excitation of m channels over steps of one length.

        Raises:
            ShapeError: If it has another number of channels.
            ParameterError: If the step is too long for it.
        """

    def __add__(self, other: "Excitation") -> "Excitation":
        """Both at once on the same channels, independent: a `Superposition`.

        Raises:
            ParameterError: If the other is no excitation.
        """
        from ftcfa.vibration.superposition import Superposition  # it is an excitation itself

        return Superposition((self, other))


@dataclass(frozen=True, eq=False)
class WhiteNoise(Excitation):
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
                "WhiteNoise intensity", f"{varpi.shape[0]} channels", f"{channels} channels", EACH
            )
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

    @property
    def normals(self) -> int:
        """As many as there are channels."""
        return len(self.sigma)

    def advance(self, state: tuple[()], normals: Array, row: Array) -> tuple[Array, tuple[()]]:  # noqa: ARG002
        """See `Process.advance`."""
        return self.sigma @ normals * np.sqrt(self.step), state

    def obstacle(self, channel: int) -> str:  # noqa: ARG002
        """See `Process.obstacle`."""
        return "white noise, whose integral is a random walk"
