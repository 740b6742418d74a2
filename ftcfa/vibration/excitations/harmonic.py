"""Harmonic excitation, and the process of any sum of sinusoids."""

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, finite_numbers, not_negative_numbers, positive_numbers, vector
from ftcfa.parts import Parameters, number_fields
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.spectra.spectrum import check_step

State = tuple[Traceable, Traceable]


@dataclass(frozen=True, eq=False)
class Harmonic(Excitation):
    """A sinusoid in each channel; several tones are a sum of these.

        xi(t) = amplitude cos(2 pi frequency t + phase)

    Attributes:
        amplitude: One number for all channels, or one for each, not negative [m/s^2].
        frequency: One number for all channels, or one for each [Hz].
        phase: One number for all channels, or one for each [rad]. None draws one for each path and
            channel, uniform on [0, 2 pi), which makes the excitation stationary. A sine has the
            phase -pi/2.

    Raises:
        ParameterError, ShapeError: If a parameter is not made of numbers, or out of range.
    """

    amplitude: Annotated[npt.ArrayLike, Check(not_negative_numbers, "m/s^2")]
    frequency: Annotated[npt.ArrayLike, Check(positive_numbers, "Hz")]
    phase: Annotated[npt.ArrayLike | None, Check(finite_numbers, "rad")] = None

    varies: ClassVar[Parameters] = number_fields("amplitude", "frequency", "phase")

    def process(self, channels: int, step: float) -> "TonesProcess":
        """See `Excitation.process`; the step must resolve the highest frequency."""
        amplitudes = vector("Harmonic amplitude", self.amplitude, channels)
        frequencies = vector("Harmonic frequency", self.frequency, channels)
        phases = None if self.phase is None else vector("Harmonic phase", self.phase, channels)
        check_step(float(frequencies.max()), step)
        return TonesProcess(amplitudes, frequencies, (1,) * channels, step, phases)


@dataclass(frozen=True, eq=False)
class TonesProcess(Process):
    """Sums of sinusoids over steps of one length, exact for any length.

        xi(t) = sum_k A_k cos theta_k,   W(t) = sum_k A_k/w_k sin theta_k,   theta_k' = w_k
        Y     = sum_k A_k/w_k (sin(w_k h) cos theta_k - (1 - cos(w_k h)) sin theta_k)
        U(t)  = -sum_k A_k/w_k^2 cos theta_k

    each sum over the lines of a channel. The state is W and Y of each line, shape (lines,) each:

        W+ = W + Y,   Y+ = Y - (2 sin(w h/2))^2 W+,   U = -(Y + (1 - cos(w h)) W)/(w sin(w h))

    Rounding changes phase and size of a line by some 1e-16 in each step, 1e-9 in ten million.

    Attributes:
        amplitudes: A_k of all channels, one channel after the other, shape (lines,) [m/s^2].
        frequencies: w_k/(2 pi), shape (lines,) [Hz].
        counts: Number of lines of each channel.
        step: h [s].
        phases: theta_k at time zero, shape (lines,) [rad]; None draws them, independent and
            uniform.
    """

    amplitudes: Array
    frequencies: Array
    counts: tuple[int, ...]
    step: float
    phases: Array | None = None

    normals = 0

    @cached_property
    def initial_normals(self) -> int:
        """Number of deviates that make the phases: two for each pair of lines."""
        return 2 * -(-len(self.frequencies) // 2) if self.phases is None else 0

    @cached_property
    def w(self) -> Array:
        """Angular frequencies, shape (lines,) [rad/s]."""
        return 2.0 * np.pi * self.frequencies

    @cached_property
    def sizes(self) -> Array:
        """A_k/w_k, shape (lines,) [m/s]."""
        return self.amplitudes / self.w

    @cached_property
    def sine(self) -> Array:
        """sin(w h), shape (lines,)."""
        return np.sin(self.w * self.step)

    @cached_property
    def versine(self) -> Array:
        """1 - cos(w h) to all digits, shape (lines,)."""
        return 2.0 * np.sin(0.5 * self.w * self.step) ** 2

    def init(self, normals: Traceable) -> State:
        """See `Process.init`."""
        c, s = self._directions(normals)
        return self.sizes * s, self.sizes * (self.sine * c - self.versine * s)

    def _directions(self, normals: Traceable) -> State:
        """Cosines and sines at time zero, two from two normals: Box and Muller's formula inverted.

        The direction of (n1, n2) is uniform. exp(-(n1^2 + n2^2)/2) is uniform on (0, 1] and
        independent of the direction.
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

    def advance(self, state: State, normals: Traceable, row: Traceable) -> tuple[Traceable, State]:
        """See `Process.advance`."""
        W, Y = state
        after = W + Y
        return self._sums(Y), (after, Y - 2.0 * self.versine * after)

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`: all channels have both."""
        return ""

    def integrals(self, state: State, row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        W, Y = state
        return self._sums(W), self._sums((Y + self.versine * W) / (-self.w * self.sine))

    def _sums(self, terms: Traceable) -> Traceable:
        """Sum over the lines of each channel, shape (m,)."""
        ends = accumulate(self.counts, initial=0)
        return np.stack([np.sum(terms[i:j]) for i, j in pairwise(ends)])
