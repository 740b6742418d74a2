"""Feed-forward of the base's motion: exact where it can be, and never a harm by its rule."""

from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    CONTROLLERS,
    FTCF,
    Accelerometer,
    Actuators,
    BaseAcceleration,
    BaseMotion,
    ClosedLoop,
    Constant,
    FeedForward,
    Gyroscope,
    Hardware,
    Harmonic,
    JointTorque,
    LinearFilter,
    ParameterError,
    Predictor,
    RandomPhase,
    Road,
    ShapedNoise,
    ShapeError,
    Sinusoid,
    Spectrum,
    Vibration,
    WhiteNoise,
    accelerometer_profile,
    base_predictor,
    feed_forward_band,
    load_arm,
    simulate,
    simulate_paths,
    with_feed_forward,
)

PANDA = load_arm("panda")
TRUCK = ShapedNoise.from_psd(
    *(f"mil_std_810g_highway_truck_{axis}" for axis in ("longitudinal", "transverse", "vertical"))
)
WORSE = 1.02
"""Largest ratio of an error with feed-forward to that without which counts as none."""


def sea(frequency=0.2, damping=0.1, rms=1.0):
    """Noise about a frequency [Hz] of a root mean square [m/s^2]: a ship, for example."""
    w = 2 * np.pi * frequency
    A = np.array([[0.0, 1.0], [-(w**2), -2 * damping * w]])
    B = np.array([[0.0], [rms * np.sqrt(4 * damping * w)]])
    return ShapedNoise(LinearFilter(A, B, np.array([[0.0, 1.0]])))


def panda(excitation, axes="z", rate=np.inf, delay=1e-3, **changes):
    """A shaken Panda with an accelerometer."""
    hardware = Hardware(
        actuators=Actuators(rate_limit=rate), accelerometer=Accelerometer(delay=delay)
    )
    parts = {
        "controller": FTCF(PANDA, compensation="bias"),
        "reference": Sinusoid(0.3, offset=PANDA.home),
        "vibration": excitation and Vibration(BaseAcceleration(axes), excitation),
        "hardware": hardware,
    }
    return ClosedLoop(PANDA, **{**parts, **changes})


def rms(loop, duration=3.0, paths=8, seed=1):
    """Root mean square of the overall tracking error after a second, over some paths."""
    ote = simulate_paths(loop, paths, duration, seed=seed, record_every=5).ote
    return float((ote.sel(time=slice(1.0, None)) ** 2).mean() ** 0.5)


def test_it_is_the_load_of_the_motion_that_was_measured():
    loop = panda(Harmonic(2.0, 3.0), delay=0.0)
    loop = replace(loop, controller=FeedForward(PANDA, loop.controller))
    found = simulate(loop, 0.3, signals="all")
    a = np.asarray(found.base_measured) + PANDA.gravity
    for k in (5, 100, 250):
        load = PANDA.base_coupling(np.asarray(found.q[k]))[:, :3] @ a[k]
        np.testing.assert_allclose(found.u_feed_forward[k], load, atol=1e-9)
    assert np.ptp(a[:, 2]) > 3.0
    assert found.u_feed_forward.units == "N m"


@pytest.mark.parametrize("law", [law for law in CONTROLLERS if "printed" not in law])
def test_every_law_takes_it(law):
    loop = panda(Harmonic(2.0, 1.0), controller=CONTROLLERS[law](PANDA))
    helped = replace(loop, controller=FeedForward(PANDA, loop.controller))
    before, after = rms(loop, paths=1), rms(helped, paths=1)
    rejects = law == "SuperTwisting"  # its integral part knows a sine already: 0.03 mrad
    assert after < (WORSE if rejects else 0.6) * before


def test_both_engines():
    loop = panda(ShapedNoise(Road("D", 15.0)), rate=1000.0, substeps=2)
    law = FeedForward(PANDA, loop.controller, 20.0, base_predictor(loop))
    it = replace(loop, controller=law)
    one, other = (simulate(it, 0.2, signals="all", engine=e) for e in ("compiled", "interpreted"))
    for name in one.data_vars:
        np.testing.assert_allclose(one[name], other[name], atol=1e-9)


def test_six_axes_on_a_base_that_turns():
    """A base that swings by degrees: three axes see the tilt, six its rates as well."""
    swing = RandomPhase(Spectrum([0.4, 1.0, 3.0], [6.0, 6.0, 0.5]), lines=60)
    base = Vibration(BaseMotion("", "x"), swing)
    six = Accelerometer(6, gyroscope=Gyroscope())
    loop = panda(None, vibration=base, hardware=Hardware(accelerometer=six))
    plain = rms(loop, paths=4)
    law = FeedForward(PANDA, loop.controller)
    three = replace(loop, controller=law, hardware=Hardware(accelerometer=Accelerometer()))
    errors = plain, rms(three, paths=4), rms(replace(loop, controller=law), paths=4)
    assert errors[1] < 0.9 * errors[0]
    assert errors[2] < 0.3 * errors[0]
    assert errors[2] < errors[1]


@pytest.mark.parametrize("rate", [1000.0, 20_000.0, np.inf])
@pytest.mark.parametrize("delay", [1e-3, 1e-2])
@pytest.mark.parametrize("base", ["truck", "ship"])
def test_the_rule_never_makes_the_arm_worse(base, delay, rate):
    excitation, axes, substeps = (TRUCK, "xyz", 4) if base == "truck" else (sea(), "z", 1)
    loop = panda(excitation, axes, rate, delay, substeps=substeps)
    chosen = with_feed_forward(loop)
    if chosen is loop:  # no band helps: where the motors or the sensor are too slow for a truck
        assert base == "truck"
        assert rate < np.inf
        return
    before, after = rms(loop, 2.0), rms(chosen, 2.0)
    assert after < WORSE * before
    if base == "ship":
        assert after < 0.6 * before


def test_the_rule_predicts_what_it_wins():
    for rate, delay in ((np.inf, 1e-3), (np.inf, 1e-2), (20_000.0, 1e-3)):
        loop = panda(TRUCK, "xyz", rate, delay, substeps=4)
        found = feed_forward_band(loop)
        helped = replace(loop, controller=FeedForward(PANDA, loop.controller, found.band))
        won = rms(helped) / rms(loop)
        assert won == pytest.approx(found.error, abs=0.12)
        assert found.peak_rate <= 0.4


def test_a_motor_that_cannot_follow_gets_none():
    assert feed_forward_band(panda(TRUCK, "xyz", 1000.0, substeps=4)).band is None
    assert feed_forward_band(panda(Harmonic(5.0, 10.0), rate=1000.0, delay=1e-2)).band is None
    for frequency in (0.17, 5.0):  # also one whose periods do not fill the realised motion
        assert feed_forward_band(panda(Harmonic(5.0, frequency), rate=1000.0)).band == np.inf


def test_the_predictor_wins_back_most_of_the_delay_of_a_road():
    loop = panda(ShapedNoise(Road("D", 15.0)), delay=1e-2, substeps=2)
    held = FeedForward(PANDA, loop.controller)
    ahead = FeedForward(PANDA, loop.controller, predictor=base_predictor(loop))
    late, predicted = (rms(replace(loop, controller=law)) for law in (held, ahead))
    at_once = rms(replace(loop, controller=held, hardware=Hardware(accelerometer=Accelerometer())))
    assert late - predicted > 0.8 * (late - at_once)


def test_the_predictor_is_the_conditional_mean():
    """Of a first-order filter it is known: the reading now, times e^(-t/T)."""
    corner = 2.0
    filter = LinearFilter([[-corner]], [[1.0]], [[1.0]])
    loop = panda(ShapedNoise(filter), delay=5e-3)
    it = base_predictor(loop)
    x = it.init()
    for a in (1.0, 0.3, -0.7):
        prediction, x = it.step(x, np.array([0.0, 0.0, a]))
        expected = a * np.exp(-corner * (5e-3 + 1e-3))
        np.testing.assert_allclose(prediction, [0.0, 0.0, expected], rtol=1e-2)


def test_wrong_feed_forward():
    law = FTCF(PANDA)
    with pytest.raises(ParameterError, match=r"no reading of the base, expected an accelerometer"):
        simulate(panda(WhiteNoise(0.1), controller=FeedForward(PANDA, law), hardware=None), 0.1)
    with pytest.raises(ParameterError, match=r"feed-forward: no accelerometer"):
        feed_forward_band(panda(WhiteNoise(0.1), hardware="fr3"))
    still = panda(None, vibration=Vibration(JointTorque(), WhiteNoise(0.1)))
    with pytest.raises(ParameterError, match=r"a base that does not move"):
        feed_forward_band(still)
    with pytest.raises(ParameterError, match=r"expected BaseAcceleration and ShapedNoise"):
        base_predictor(panda(Harmonic(1.0, 1.0)))
    with pytest.raises(ShapeError, match=r"expected \(N, N\), \(N, 3\)"):
        Predictor(np.eye(2), np.eye(3), np.eye(3), np.eye(3))
    with pytest.raises(ParameterError, match="FeedForward band"):
        FeedForward(PANDA, law, -1.0)


def test_it_needs_no_motion_to_hold_still():
    hardware = Hardware(accelerometer=Accelerometer())
    law = FeedForward(PANDA, FTCF(PANDA, compensation="bias"))
    loop = ClosedLoop(PANDA, law, Constant(PANDA.home), hardware=hardware)
    found = simulate(loop, 0.1, signals=["u_feed_forward"])
    np.testing.assert_allclose(found.u_feed_forward, 0.0, atol=1e-12)


SWING = Vibration(BaseMotion("", "x"), Harmonic(3.0, 1.0))
"""A base that swings about x, 3 rad/s^2 at 1 Hz: some 4 degrees."""


@pytest.mark.parametrize(
    "given",
    [
        Accelerometer(6, gyroscope=Gyroscope(1e-3), delay=1e-3),
        Accelerometer(6, gyroscope=Gyroscope(1e-2), delay=1e-3),
        Accelerometer(6, noise_density=0.03, gyroscope=Gyroscope(0.0, range=0.1), delay=1e-3),
    ],
    ids=["gyroscopes with noise", "with much noise", "out of range"],
)
def test_the_rule_knows_the_gyroscope(given):
    loop = panda(None, vibration=SWING, hardware=Hardware(accelerometer=given))
    assert rms(with_feed_forward(loop)) <= WORSE * rms(loop)


@pytest.mark.parametrize("name", ["low_noise_mems", "industrial_mems", "phone"])
@pytest.mark.parametrize("base", [Harmonic(0.5, 1.0), Harmonic(2.0, 1.0), "truck"], ids=str)
@pytest.mark.parametrize("law", ["FTCF", "ComputedTorque"])
def test_the_rule_knows_bias_range_and_noise_of_real_sensors(name, base, law):
    excitation = TRUCK if base == "truck" else base
    loop = panda(
        excitation,
        "xyz" if base == "truck" else "z",
        controller=CONTROLLERS[law](PANDA),
        hardware=Hardware(accelerometer=accelerometer_profile(name)),
        substeps=4,
    )
    assert rms(with_feed_forward(loop), 2.0, 4) <= WORSE * rms(loop, 2.0, 4)


def test_a_reading_beyond_its_range_is_no_reading():
    """Gravity alone is beyond 9 m/s^2, and a clipped reading feeds nothing forward."""
    clipped = Hardware(accelerometer=Accelerometer(range=9.0))
    found = feed_forward_band(panda(Harmonic(2.0, 1.0), hardware=clipped))
    assert found.band is None
    assert "out of range" in found.why


def test_why_there_is_none():
    found = feed_forward_band(panda(Harmonic(5.0, 6.33), rate=1000.0))
    assert found.band is None
    assert "of the torque rate limit of panda_joint4; the rule allows 0.4" in found.why
    still = feed_forward_band(panda(Harmonic(0.0, 3.0)))
    assert (still.band, still.why) == (None, "the base does not move")
    with pytest.raises(ParameterError, match="feed-forward: a int, expected a ClosedLoop"):
        feed_forward_band(3)


@pytest.mark.parametrize("delay", [0.0, 5e-3])
def test_a_base_that_turns_already_does_not_kick_the_arm(delay):
    sensor = Accelerometer(6, gyroscope=Gyroscope(), delay=delay)
    loop = panda(None, vibration=SWING, hardware=Hardware(accelerometer=sensor))
    loop = replace(loop, controller=FeedForward(PANDA, loop.controller))
    load = np.abs(simulate(loop, 1.5, signals="all").u_feed_forward.values)
    assert load[:50].max() <= 1.05 * load[50:].max()


def test_readings_that_are_held_are_differentiated_over_their_interval():
    """At 100 Hz the load is that at 1 kHz but for the hold: no spikes every tenth sample."""
    loads = []
    for rate in (None, 100.0):
        sensor = Accelerometer(6, gyroscope=Gyroscope(), rate=rate)
        loop = panda(None, vibration=SWING, hardware=Hardware(accelerometer=sensor))
        loop = replace(loop, controller=FeedForward(PANDA, loop.controller))
        loads.append(simulate(loop, 1.0, signals="all").u_feed_forward.values[100:])
    scale = np.abs(loads[0]).max()
    assert np.abs(loads[1]).max() <= 1.1 * scale
    assert np.abs(loads[1] - loads[0]).max() <= 0.2 * scale


def test_a_predictor_wants_every_sample_and_knows_the_level():
    slow = Hardware(accelerometer=Accelerometer(rate=100.0))
    with pytest.raises(ParameterError, match="100 Hz, expected a reading at every sample, 1000 Hz"):
        base_predictor(panda(sea(), hardware=slow))
    noisy = Hardware(accelerometer=Accelerometer(noise_density=0.05))
    loop = panda(sea(), hardware=noisy)
    weak = replace(loop, vibration=replace(loop.vibration, level=0.1))
    same = Hardware(accelerometer=Accelerometer(noise_density=0.5))
    np.testing.assert_allclose(
        base_predictor(weak).K, base_predictor(panda(sea(), hardware=same)).K, rtol=1e-9
    )
