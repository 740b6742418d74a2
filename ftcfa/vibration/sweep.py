"""A sine that sweeps through frequencies, up and down, as test benches do."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, positive, vector
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.tones import check_frequency, check_numbers, not_negative

Kind = Literal["logarithmic", "linear"]
KINDS = ("logarithmic", "linear")
State = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class SineSweep(Excitation):
    """A sine from one frequency to another in ``duration``, back in as long, and so on.

        xi(t) = amplitude sin theta(t),   theta' = 2 pi f(t),   theta(0) = 0
        f = start (stop/start)^(x/T)  or  start + (stop - start) x/T

    with x the time since the last sweep began, and counted back on the way back; the phase is
    continuous. All channels are in phase, and all paths are the same.

    Attributes:
        amplitude: A number, or one a channel, not negative [m/s^2].
        start: Frequency at time zero [Hz].
        stop: Frequency after ``duration``; it may be the lower one [Hz].
        duration: T [s].
        kind: ``"logarithmic"`` (as many seconds an octave everywhere) or ``"linear"``.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If one is out of range or unknown.
    """

    amplitude: npt.ArrayLike
    start: float
    stop: float
    duration: float
    kind: Kind = "logarithmic"

    def __post_init__(self) -> None:
        check_numbers("SineSweep amplitude", self.amplitude, not_negative, "numbers >= 0 [m/s^2]")
        positive("SineSweep start", self.start, "[Hz]")
        positive("SineSweep stop", self.stop, "[Hz]")
        positive("SineSweep duration", self.duration, "[s]")
        if self.kind not in KINDS:
            raise UnknownNameError("SineSweep kind", str(self.kind), KINDS)
        if self.start == self.stop:
            raise ParameterError(
                "SineSweep stop", f"{self.stop:g} Hz, as start", "two frequencies", "take Harmonic"
            )

    def frequency(self, x: Array) -> Array:
        """Frequency at the time x of a sweep, 0 <= x <= T [s] -> [Hz]."""
        share = x / self.duration
        if self.kind == "linear":
            return self.start + (self.stop - self.start) * share
        return self.start * np.exp(np.log(self.stop / self.start) * share)

    def turns(self, x: Array) -> Array:
        """Phase at the time x of a sweep, the integral of the frequency [s] -> [turns]."""
        share = x / self.duration
        if self.kind == "linear":
            return (self.start + 0.5 * (self.stop - self.start) * share) * x
        ratio = np.log(self.stop / self.start)
        return self.start * self.duration / ratio * np.expm1(ratio * share)

    def process(self, channels: int, step: float) -> "SweepProcess":
        """See `Excitation.process`; the step must resolve the highest frequency."""
        check_frequency(max(self.start, self.stop), step)
        return SweepProcess(vector("SineSweep amplitude", self.amplitude, channels), self, step)


class SweepProcess(Process):
    """A sweep over steps of one length; the state is the number of the step, and W.

        Y = a h sinc(f h) sin theta,   f and theta at the middle of the step

    The phase is a closed form of the time, exact to rounding (1e-16 of the turns made). Over a
    step the frequency counts as constant: Y is off by at most a h (theta'' h^2)/24.

    W begins at -a/theta', where a sine's integral of mean zero does, and sums up Y. A change of
    direction shifts its mean by up to 2 a theta''/theta'^3, small for a sweep that takes many
    periods; the shifts come with other phases each time and need not add up.
    """

    normals = 0

    def __init__(self, amplitude: Array, sweep: SineSweep, step: float) -> None:
        self.amplitude, self.sweep, self.step = amplitude, sweep, step
        self.integrable = frozenset(range(len(amplitude)))

    def init(self, normals: Array) -> State:  # noqa: ARG002
        """Before the first step: none made."""
        return np.zeros(()), -self.amplitude / (2.0 * np.pi * self.sweep.start)

    def advance(self, state: State, normals: Array, row: Array) -> tuple[Array, State]:  # noqa: ARG002
        """See `Process.advance`."""
        steps, W = state
        f, turns = self._at((steps + 0.5) * self.step)
        held = np.sin(np.pi * f * self.step) / (np.pi * f)
        Y = self.amplitude * (held * np.sin(2.0 * np.pi * turns))
        return Y, (steps + 1.0, W + Y)

    def rate(self, state: State, row: Array) -> Array:  # noqa: ARG002
        """See `Process.rate`."""
        return state[1]

    def _at(self, t: Array) -> tuple[Array, Array]:
        """Frequency [Hz] and phase [turns, whole ones taken off] at a time [s]."""
        T = self.sweep.duration
        cycle = np.floor(t / (2.0 * T))
        since = t - 2.0 * T * cycle
        x = T - np.abs(since - T)
        there = self.sweep.turns(x)
        both = 2.0 * self.sweep.turns(np.asarray(T))
        turns = np.where(since < T, there, both - there) + cycle * np.mod(both, 1.0)
        return self.sweep.frequency(x), turns - np.floor(turns)
