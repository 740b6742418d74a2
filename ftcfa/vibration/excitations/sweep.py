"""A sine that sweeps through frequencies, up and down, as on test benches."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, not_negative_numbers, positive, vector
from ftcfa.errors import ParameterError
from ftcfa.parts import Parameters, number_fields
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.spectra.spectrum import check_step

Kind = Literal["logarithmic", "linear"]


@dataclass(frozen=True, eq=False)
class SineSweep(Excitation):
    """A sine that sweeps from one frequency to another in ``duration``, back again, and so on.

        xi(t) = amplitude sin theta(t),   theta' = 2 pi f(t),   theta(0) = 0
        f = start (stop/start)^(x/T)  or  start + (stop - start) x/T

    with x the time since the last sweep up began, which decreases on the way back. The phase is
    continuous. All channels are in phase, and all paths are the same. `SweepProcess` states which
    of this holds only to first order in the change of frequency over a period.

    Attributes:
        amplitude: One number for all channels, or one for each, not negative [m/s^2].
        start: Frequency at time zero [Hz].
        stop: Frequency after ``duration``, above or below ``start`` [Hz].
        duration: T [s].
        kind: ``"logarithmic"`` (each octave takes the same time) or ``"linear"``.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If a parameter is out of range or unknown.
    """

    amplitude: Annotated[npt.ArrayLike, Check(not_negative_numbers, "m/s^2")]
    start: Annotated[float, Check(positive, "Hz")]
    stop: Annotated[float, Check(positive, "Hz")]
    duration: Annotated[float, Check(positive, "s")]
    kind: Kind = "logarithmic"

    varies: ClassVar[Parameters] = number_fields("amplitude", "start", "stop", "duration")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.start == self.stop:
            got, remedy = f"{self.stop:g} Hz, as start", "take Harmonic"
            raise ParameterError("SineSweep stop", got, "two frequencies", remedy, field="stop")

    def frequency(self, x: Traceable) -> Traceable:
        """Frequency at the time x of a sweep up, 0 <= x <= T [s] -> [Hz]."""
        share = x / self.duration
        if self.kind == "linear":
            return self.start + (self.stop - self.start) * share
        return self.start * np.exp(np.log(self.stop / self.start) * share)

    def turns(self, x: Traceable) -> Traceable:
        """Phase at the time x of a sweep up, the integral of the frequency [s] -> [turns]."""
        share = x / self.duration
        if self.kind == "linear":
            return (self.start + 0.5 * (self.stop - self.start) * share) * x
        ratio = np.log(self.stop / self.start)
        return self.start * self.duration / ratio * np.expm1(ratio * share)

    def process(self, channels: int, step: float) -> "SweepProcess":
        """See `Excitation.process`; the step must resolve the highest frequency."""
        check_step(max(self.start, self.stop), step)
        return SweepProcess(vector("SineSweep amplitude", self.amplitude, channels), self, step)


@dataclass(frozen=True, eq=False)
class SweepProcess(Process):
    """A sweep over steps of one length; the state is the number of steps since time zero.

        W = -a cos(theta)/theta',   U = -a sin(theta)/theta'^2,   Y = W(t + h) - W(t)

    The phase is a closed form of the time, exact to rounding (1e-16 of the turns), so nothing
    drifts. W is the integral of a (sin(theta) + d cos(theta)), d = theta''/theta'^2: the amplitude
    has the relative error d^2/2, where the frequency changes by the share 2 pi d in a period. U is
    the integral of W with the error 2 d in the same sense.

    Attributes:
        amplitude: a, shape (m,) [m/s^2].
        sweep: The sweep.
        step: h [s].
    """

    amplitude: Array
    sweep: SineSweep
    step: float

    normals = 0

    def init(self, normals: Traceable) -> Traceable:
        """Number of steps at time zero."""
        return np.zeros(())

    def advance(
        self, state: Traceable, normals: Traceable, row: Traceable
    ) -> tuple[Traceable, Traceable]:
        """See `Process.advance`."""
        now, _ = self.integrals(state, row)
        then, _ = self.integrals(state + 1.0, row)
        return then - now, state + 1.0

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`: all channels have both."""
        return ""

    def integrals(self, state: Traceable, row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        f, turns = self._at(state * self.step)
        w, theta = 2.0 * np.pi * f, 2.0 * np.pi * turns
        return -self.amplitude * (np.cos(theta) / w), -self.amplitude * (np.sin(theta) / w**2)

    def _at(self, t: Traceable) -> tuple[Traceable, Traceable]:
        """Frequency [Hz] and phase, less whole turns [turns], at a time [s]."""
        T = self.sweep.duration
        cycle = np.floor(t / (2.0 * T))
        since = t - 2.0 * T * cycle
        x = T - np.abs(since - T)
        there = self.sweep.turns(x)
        both = 2.0 * self.sweep.turns(np.asarray(T))
        turns = np.where(since < T, there, both - there) + cycle * np.mod(both, 1.0)
        return self.sweep.frequency(x), turns - np.floor(turns)
