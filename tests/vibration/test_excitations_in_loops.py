"""Excitations with a memory run in the loop: the same on both engines, with the right spectrum."""

import numpy as np
import pytest
from scipy import signal, stats

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    LinearFilter,
    ParameterError,
    Record,
    RecordedAcceleration,
    ShapedNoise,
    ShapeError,
    Sinusoid,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
    standard,
)

from .masses import CONFIDENCE, Mass, Push, Rest, check_engines, pushed

TRUCK = "mil_std_810g_highway_truck_vertical"


def on_a_truck(**changes):
    arm = load_arm("ur5")
    axes = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]
    vibration = Vibration(BaseAcceleration("xyz"), ShapedNoise.from_psd(*axes))
    reference = Sinusoid(offset=arm.home)
    return ClosedLoop(arm, FTCF(arm, compensation="bias"), reference, vibration, **changes)


def recorded(samples=200, axes=1):
    values = np.random.default_rng(0).standard_normal((samples, axes))
    values = signal.sosfilt(signal.butter(4, 50.0, fs=1e3, output="sos"), values, axis=0)
    return RecordedAcceleration(Record(1e-3, values))


@pytest.mark.parametrize(
    "loop", [on_a_truck(substeps=4), pushed(recorded()), pushed(recorded(), substeps=3)]
)
def test_the_engines_agree(loop):
    check_engines(loop, 0.3)


def test_a_path_is_the_same_alone_and_in_a_batch():
    loop = on_a_truck(substeps=4)
    batch = simulate_paths(loop, 20, 0.1)
    np.testing.assert_array_equal(simulate(loop, 0.1, path=13).q, batch.q.sel(path=13))


def test_the_force_is_stationary_from_the_first_step():
    """The variance of the first increment is the last one's, and the filter's own."""
    loop = pushed(ShapedNoise.from_psd(TRUCK), period=2.5e-4)
    paths = 4000
    v = simulate_paths(loop, paths, 0.05).v.values[:, :, 0]
    increments = np.diff(v, axis=1)
    (sampled,) = (f.discretise(2.5e-4) for f in loop.vibration.excitation.filters)
    exact = sampled.covariance(0)[0, 0]
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    for k in (0, 1, 100, increments.shape[1] - 1):
        assert low < np.mean(increments[:, k] ** 2) / exact < high


def test_the_realised_spectrum_is_the_specified_one():
    """Welch over many paths, within the fit's 1.5 dB and the estimate's own error."""
    step, paths = 2.5e-4, 64
    loop = pushed(ShapedNoise.from_psd(TRUCK), period=step)
    acceleration = np.diff(simulate_paths(loop, paths, 4.0).v.values[:, :, 0], axis=1) / step
    f, densities = signal.welch(acceleration, 1 / step, nperseg=4096)
    inside = (f > 12) & (f < 450)
    specified = standard(TRUCK).spectrum.density(f[inside])
    deviation = 10 * np.log10(densities.mean(axis=0)[inside] / specified)
    assert np.max(np.abs(deviation)) < 1.5 + 1.0  # some 450 averages: 1 dB is five deviations


def test_the_density_of_white_noise_is_twice_its_intensity():
    """One-sided, per hertz: Welch over many paths."""
    varpi, step, paths = 0.3, 1e-3, 64
    v = simulate_paths(pushed(WhiteNoise(varpi)), paths, 8.192).v.values[:, :, 0]
    _, densities = signal.welch(np.diff(v, axis=1) / step, 1 / step, nperseg=256)
    density = densities.mean(axis=0)[2:-2]  # what the detrending leaves alone
    deviations = stats.norm.isf((1 - CONFIDENCE) / len(density) / 2)
    independent = paths * 63 / 2  # half-overlapping Hann segments count at least half
    assert np.abs(density / (2 * varpi) - 1).max() < deviations / np.sqrt(independent)
    assert np.mean(density) == pytest.approx(2 * varpi, rel=0.01)


def test_a_level_is_a_factor_on_the_amplitude():
    loop = pushed(ShapedNoise.from_psd(TRUCK), period=2.5e-4)
    v = simulate_paths(loop, [7, 7], 0.01, vary={"vibration.level": [1.0, 3.0]}).v.values
    np.testing.assert_allclose(v[1], 3.0 * v[0], rtol=1e-12)


def test_a_record_is_replayed_from_a_moment_of_the_paths_own():
    source = recorded(samples=500)
    loop = pushed(source)
    v = simulate_paths(loop, 40, 0.499).v.values[:, :, 0]
    rows = source.process(1, 1e-3).rows[:, 0]
    starts = set()
    for increments in np.diff(v, axis=1):
        start = int(np.argmin(np.abs(rows - increments[0])))
        starts.add(start)
        np.testing.assert_allclose(increments, np.roll(rows, -start)[:499], atol=1e-12)
    assert len(starts) > 30  # 40 draws out of 500: three collisions are to be expected


def test_a_record_can_begin_at_its_beginning():
    source = RecordedAcceleration(recorded().record, random_start=False)
    v = simulate_paths(pushed(source), 3, 0.05).v.values[:, :, 0]
    np.testing.assert_allclose(
        np.diff(v, axis=1)[2], source.process(1, 1e-3).rows[:50, 0], atol=1e-12
    )


def test_a_step_too_long_for_the_band_is_refused():
    with pytest.raises(ParameterError, match=r"up to 500 Hz.*take substeps=4"):
        on_a_truck()


def test_the_channels_must_be_as_many_as_the_inputs():
    with pytest.raises(ShapeError, match="ShapedNoise: 2 channels, expected 1 channels"):
        pushed(ShapedNoise.from_psd(TRUCK, TRUCK), period=2.5e-4)
    with pytest.raises(ShapeError, match="RecordedAcceleration: 2 axes, expected 1 channels"):
        pushed(recorded(axes=2))


def test_unknown_specifications_are_refused():
    with pytest.raises(UnknownNameError, match="gevs_acceptance"):
        ShapedNoise.from_psd("highway")
    with pytest.raises(ParameterError, match="spectrum: 3, expected a standard's"):
        ShapedNoise.from_psd(3)


def test_the_stationary_variance_is_lyapunovs():
    """A damped mass under shaped noise: exact joint covariance against the ensemble's."""
    w, zeta, omega = 30.0, 0.2, 20.0

    class Oscillator(Mass):
        def bias_force(self, q, v):
            return 2 * zeta * w * v + w**2 * q

    shaping = LinearFilter(
        np.array([[0.0, 1.0], [-(omega**2), -omega]]),
        np.array([[0.0], [50.0]]),
        np.array([[1.0, 0.0]]),
    )
    A = np.zeros((4, 4))
    A[:2, :2], A[3, 2] = shaping.A, 1.0  # x, x', then v, q
    A[2] = [1.0, 0.0, -2 * zeta * w, -(w**2)]
    joint = LinearFilter(A, np.vstack([shaping.B, np.zeros((2, 1))]), np.eye(4)).covariance()
    loop = ClosedLoop(
        Oscillator(), Rest(), Sinusoid(0.0), Vibration(Push(), ShapedNoise((shaping,))),
        period=2e-4, integrator="semi-implicit",
    )  # fmt: skip
    paths = 4000
    q = simulate_paths(loop, paths, 1.5, record_every=7500).q.values[:, -1, 0]
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    assert low < np.mean(q**2) / joint[3, 3] < high


def test_the_variance_of_an_arm_on_a_shaken_base_is_lyapunovs(tmp_path):
    """A damped rod of a URDF, hanging: exact covariance for small angles against the ensemble's."""
    mass, centre, inertia, damping, level = 2.0, 0.5, 0.02, 0.6, 0.2
    file = tmp_path / "rod.urdf"
    file.write_text(
        f'''<robot name="rod"><link name="base"/><link name="rod"><inertial>
        <origin xyz="0 0 {-centre}"/><mass value="{mass}"/><inertia ixx="{inertia}" ixy="0" ixz="0"
        iyy="{inertia}" iyz="0" izz="0.001"/></inertial></link><joint name="j" type="revolute">
        <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/><dynamics damping="{damping}"/>
        <limit lower="-3" upper="3" effort="50" velocity="9"/></joint></robot>'''
    )
    arm, noise = load_arm(file, gravity=9.81), ShapedNoise("astm_d4169_truck_low")
    (shaping,) = noise.filters
    N, J = shaping.order, inertia + mass * centre**2
    A = np.zeros((N + 2, N + 2))
    A[:N, :N], A[N, N + 1] = shaping.A, 1.0
    A[N + 1, :N] = level * mass * centre / J * shaping.C[0]  # either sign: the variance is one
    A[N + 1, N:] = -mass * 9.81 * centre / J, -damping / J
    B = np.vstack([shaping.B, np.zeros((2, 1))])
    exact = np.diag(LinearFilter(A, B, np.eye(N + 2)).covariance())[N:]
    assert np.sqrt(exact[0]) < 0.02  # rad: sin q is q to 1e-4
    loop = ClosedLoop(
        arm, Rest(), Constant([0.0]), Vibration(BaseAcceleration("x"), noise, level),
        period=5e-4, integrator="semi-implicit",
    )  # fmt: skip
    paths = 4000
    last = simulate_paths(loop, paths, 12.0, record_every=24_000).isel(time=-1)
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    for name, variance in zip("qv", exact, strict=True):
        assert low < np.mean(last[name].values ** 2) / variance < high
