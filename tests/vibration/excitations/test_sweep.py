"""Sine sweeps against scipy's chirp, exact arithmetic, and quadrature."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import chirp

from ftcfa import ParameterError, ShapeError, SineSweep, UnknownNameError, simulate

from ..masses import check_engines, pushed, run_process

KINDS = ("logarithmic", "linear")
SWEEPS = [(kind, *ends) for kind in KINDS for ends in ((5.0, 80.0), (80.0, 5.0))]


def change(sweep, x):
    """theta''/theta'^2 of a sweep at the times x of its way there."""
    f = sweep.frequency(x)
    slope = abs(sweep.stop - sweep.start) / sweep.duration
    if sweep.kind == "logarithmic":
        slope = f * abs(np.log(sweep.stop / sweep.start)) / sweep.duration
    return slope / (2 * np.pi * f**2)


@pytest.mark.parametrize(("kind", "start", "stop"), SWEEPS)
def test_the_first_sweep_is_scipy_s_chirp(kind, start, stop):
    """Integrals of the chirp by quadrature, within the documented a h theta''/theta'^2."""
    T, h, a = 4.0, 1e-3, 2.0

    def exact(t):
        return a * chirp(t, start, T, stop, method=kind, phi=-90)

    sweep = SineSweep(a, start, stop, T, kind)
    Y, *_ = run_process(sweep.process(1, h), 4000)
    for k in [*range(0, 4000, 97), 3999]:
        integral = quad(exact, k * h, (k + 1) * h, epsabs=1e-14)[0]
        ends = h * np.array([k, k + 1])
        assert Y[k, 0] == pytest.approx(integral, abs=a * h * change(sweep, ends).max())


@pytest.mark.parametrize(("kind", "start", "stop"), SWEEPS)
def test_up_and_down_and_up_again_without_a_jump_of_phase(kind, start, stop):
    """The phase is the integral of the frequency, which goes to and fro between the two."""
    T, h = 0.7, 1e-3
    sweep = SineSweep(1.0, start, stop, T, kind)
    process = sweep.process(1, h)

    def frequency(t):
        share = 1 - abs(np.mod(t / T, 2.0) - 1)
        up = start + (stop - start) * share
        return up if kind == "linear" else start * (stop / start) ** share

    turns, last = 0.0, 0.0
    for k in range(0, 3500, 50):  # five sweeps
        t = k * h
        corners = [n * T for n in range(1, 6) if last < n * T < t]
        turns += quad(frequency, last, t, points=corners or None, epsabs=1e-13)[0]
        last = t
        W, U = process.integrals(np.float64(k), np.zeros(0))
        w = 2 * np.pi * frequency(t)
        assert W[0] == pytest.approx(-np.cos(2 * np.pi * turns) / w, abs=1e-12)
        assert U[0] == pytest.approx(-np.sin(2 * np.pi * turns) / w**2, abs=1e-12)


def test_the_phase_after_a_day_by_exact_arithmetic():
    start, stop, T = Fraction(5), Fraction(500), Fraction(60)
    process = SineSweep(1.0, 5.0, 500.0, 60.0, "linear").process(1, 2.0**-12)
    steps = 86_400 * 4096 + 77
    t = Fraction(steps, 4096)
    cycles, since = divmod(t, 2 * T)
    x = min(since, 2 * T - since)
    turns = start * x + (stop - start) * x * x / (2 * T)
    both = (start + stop) * T
    turns = (turns if since < T else both - turns) + cycles * both
    w = 2 * np.pi * float(start + (stop - start) * x / T)
    W, _ = process.integrals(np.float64(steps), np.zeros(0))
    exact = -np.cos(2 * np.pi * float(turns % 1)) / w
    assert W[0] == pytest.approx(exact, abs=1e-7 / w)  # 500 Hz, 86,400 s, 1e-16 each


@pytest.mark.parametrize(("kind", "start", "stop"), SWEEPS)
def test_its_integrals_do_not_drift(kind, start, stop):
    """Sums of Y, and of W, over 80 s stay where the first period was."""
    process = SineSweep(1.0, start, stop, 10.0, kind).process(1, 1e-3)
    steps = np.arange(80_000.0)[:, None]
    Y, _ = process.advance(steps, np.zeros(0), np.zeros(0))
    W, U = process.integrals(steps, np.zeros(0))
    np.testing.assert_allclose(W[0] + np.cumsum(Y[:-1], axis=0), W[1:], atol=1e-12)
    w = 2 * np.pi * 5.0
    assert np.abs(W).max() <= 1 / w
    assert np.abs(U).max() <= 1 / w**2
    for x, largest in ((W, 1 / w), (U, 1 / w**2)):
        assert abs(x.mean()) < 0.01 * largest


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_engines_agree(kind, substeps):
    sweep = SineSweep([1.0, 2.5], 5.0, 100.0, 0.07, kind)
    check_engines(pushed(sweep, 2, substeps=substeps), 0.3)


def test_the_channels_are_in_phase():
    v = simulate(pushed(SineSweep([1.0, 2.5], 5.0, 100.0, 1.0), 2), 0.5).v.values
    np.testing.assert_allclose(v[:, 1], 2.5 * v[:, 0], rtol=1e-12)


def test_a_step_must_resolve_the_highest_frequency():
    for ends in ((5.0, 500.0), (500.0, 5.0)):
        with pytest.raises(ParameterError, match=r"up to 500 Hz.*take substeps=4"):
            pushed(SineSweep(1.0, *ends, 10.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1.0, 5.0, 50.0, 10.0), "SineSweep amplitude: -1.0, expected numbers >= 0"),
        ((1.0, 0.0, 50.0, 10.0), r"SineSweep start: 0.0, expected a number > 0 \[Hz\]"),
        ((1.0, 5.0, 0.0, 10.0), r"SineSweep stop: 0.0, expected a number > 0 \[Hz\]"),
        ((1.0, 5.0, -1.0, 10.0), r"SineSweep stop: -1.0, expected a number > 0 \[Hz\]"),
        ((1.0, 5.0, "high", 10.0), "SineSweep stop: 'high', expected a number > 0"),
        ((1.0, 5.0, 50.0, 0.0), r"SineSweep duration: 0.0, expected a number > 0 \[s\]"),
        ((1.0, 5.0, 5.0, 1.0), "SineSweep stop: 5 Hz, as start, expected two frequencies; take"),
        (
            (1.0, 5.0, 50.0, 1.0, "octaves"),
            "SineSweep kind 'octaves': unknown name, expected one of: logarithmic, linear",
        ),
    ],
)
def test_what_is_no_sweep(arguments, message):
    with pytest.raises((ParameterError, UnknownNameError), match=message):
        SineSweep(*arguments)


def test_a_wrong_number_of_channels():
    with pytest.raises(ShapeError, match=r"SineSweep amplitude: shape \(2,\), expected a number"):
        pushed(SineSweep([1.0, 2.0], 5.0, 50.0, 1.0), 3)
