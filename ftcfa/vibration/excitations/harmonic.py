"""Harmonic excitation, and the process of any sum of sinusoids."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import (
    Check,
    check_fields,
    finite_numbers,
    not_negative_numbers,
    positive_numbers,
    vector,
)
from ftcfa.parts import Parameters, number_fields
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.spectra.spectrum import Spectrum, check_step

State = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class Harmonic(Excitation):
    """One sinusoid a channel; several tones are a sum of these.

        xi(t) = amplitude cos(2 pi frequency t + phase)

    Attributes:
        amplitude: A number, or one a channel, not negative [m/s^2].
        frequency: A number, or one a channel [Hz].
        phase: A number, or one a channel [rad]; None draws one for each path and channel, uniform
            on [0, 2 pi), which makes the excitation stationary. A sine has the phase -pi/2.

    Raises:
        ParameterError, ShapeError: If one is not a number or numbers, or out of range.
    """

    amplitude: Annotated[npt.ArrayLike, Check(not_negative_numbers, "m/s^2")]
    frequency: Annotated[npt.ArrayLike, Check(positive_numbers, "Hz")]
    phase: Annotated[npt.ArrayLike | None, Check(finite_numbers, "rad")] = None

    varies: ClassVar[Parameters] = number_fields("amplitude", "frequency", "phase")

    def __post_init__(self) -> None:
        check_fields(self)

    def process(self, channels: int, step: float) -> "TonesProcess":
        """See `Excitation.process`; the step must resolve the highest frequency."""
        amplitudes = vector("Harmonic amplitude", self.amplitude, channels)
        frequencies = vector("Harmonic frequency", self.frequency, channels)
        phases = None if self.phase is None else vector("Harmonic phase", self.phase, channels)
        check_frequency(float(frequencies.max()), step)
        return TonesProcess(amplitudes, frequencies, (1,) * channels, step, phases)


class TonesProcess(Process):
    """Sums of sinusoids over steps of one length, exact for any length.

        xi(t) = sum_k A_k cos theta_k,   W(t) = sum_k A_k/w_k sin theta_k,   theta_k' = w_k
        Y     = sum_k A_k/w_k (sin(w_k h) cos theta_k - (1 - cos(w_k h)) sin theta_k)
        U(t)  = -sum_k A_k/w_k^2 cos theta_k

    each sum over the lines of a channel. The state is each line's W and Y, shape (lines,) each:

        W+ = W + Y,   Y+ = Y - (2 sin(w h/2))^2 W+,   U = -(Y + (1 - cos(w h)) W)/(w sin(w h))

    Rounding moves phase and size of a line by some 1e-16 a step, 1e-9 in ten million.

    Args:
        amplitudes: A_k of all channels, one channel after the other, shape (lines,) [m/s^2].
        frequencies: w_k/(2 pi), shape (lines,) [Hz].
        lines: How many of them belong to each channel.
        step: h [s].
        phases: theta_k at time zero, shape (lines,) [rad]; None draws them, independent and
            uniform.
    """

    normals = 0

    def __init__(
        self,
        amplitudes: Array,
        frequencies: Array,
        lines: tuple[int, ...],
        step: float,
        phases: Array | None = None,
    ) -> None:
        w = 2.0 * np.pi * frequencies
        self.w, self.sizes = w, amplitudes / w
        self.sine = np.sin(w * step)
        self.versine = 2.0 * np.sin(0.5 * w * step) ** 2  # 1 - cos, all digits
        self.ends = np.cumsum(lines)
        self.phases = phases
        self.initial_normals = 2 * -(-len(w) // 2) if phases is None else 0

    def init(self, normals: Array) -> State:
        """See `Process.init`."""
        c, s = self._directions(normals)
        return self.sizes * s, self.sizes * (self.sine * c - self.versine * s)

    def _directions(self, normals: Array) -> State:
        """Cosines and sines at time zero, two from two normals: Box and Muller's formula backwards.

        The direction of (n1, n2) is uniform, and so is exp(-(n1^2 + n2^2)/2), on (0, 1], and
        independent of it.
        """
        if self.phases is not None:
            return np.cos(self.phases), np.sin(self.phases)
        pairs, lines = len(normals) // 2, len(self.sizes)
        first, second = normals[:pairs], normals[pairs:]
        square = first**2 + second**2
        some = square > 0
        length = np.sqrt(np.where(some, square, 1.0))
        angle = 2.0 * np.pi * np.exp(-0.5 * square)
        c = np.concatenate([np.where(some, first, 1.0) / length, np.cos(angle)])
        s = np.concatenate([second / length, np.sin(angle)])
        return c[:lines], s[:lines]

    def advance(self, state: State, normals: Array, row: Array) -> tuple[Array, State]:  # noqa: ARG002
        """See `Process.advance`."""
        W, Y = state
        after = W + Y
        return self._sums(Y), (after, Y - 2.0 * self.versine * after)

    def obstacle(self, channel: int) -> str:  # noqa: ARG002
        """See `Process.obstacle`: none."""
        return ""

    def integrals(self, state: State, row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """See `Process.integrals`."""
        W, Y = state
        return self._sums(W), self._sums((Y + self.versine * W) / (-self.w * self.sine))

    def _sums(self, terms: Array) -> Array:
        """Sum over the lines of each channel, shape (m,)."""
        starts = [0, *self.ends[:-1]]
        return np.stack([np.sum(terms[i:j]) for i, j in zip(starts, self.ends, strict=True)])


def check_frequency(frequency: float, step: float) -> None:
    """Refuse an integration step that is too long for a sinusoid, as for a band that ends there.

    Raises:
        ParameterError: Naming the frequency, the step and the substeps needed.
    """
    check_step(Spectrum(np.array([0.5, 1.0]) * frequency, np.ones(2)), step)
