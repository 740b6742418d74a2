"""`simulate`: the Dataset it gives, reproducibility, divergence, and users' own laws and plants."""

import json
import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import ftcfa
from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    Gains,
    PaperPendulum,
    ParameterError,
    ShapeError,
    Sinusoid,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.loop.state import DIVERGED

CONFIDENCE = 1.0 - 1e-6
"""Of each two-sided interval for a sample variance of normal numbers (chi-squared)."""

SIGMAS = 5.0
"""Correlations lie within 5 standard errors: a right engine fails one in some 10,000 runs."""
ROUNDING = 1e-12
"""Compiled code may fuse products and sums, differently in every program."""

TOOL = {"tool_error", "tool_angle_error"}
FTCF_SIGNALS = {"alpha", "abar", "z1", "z2", "v1", "v2", "s1", "s2", "rho", "theta"}
ALWAYS = {"q", "q_d", "v", "u", "ote", "diverged_at"}


@pytest.fixture(params=["interpreted", "compiled"])
def engine(request):
    return request.param


@pytest.fixture(scope="module")
def loop():
    arm = load_arm("double_pendulum", gravity=9.8)
    return ClosedLoop(
        arm,
        FTCF(arm),
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        Vibration(BaseAcceleration("xz"), WhiteNoise(0.1)),
        q0=[-0.1, 0.25],
        v0=[-0.3, 0.45],
    )


@dataclass(frozen=True, eq=False)
class Oscillators:
    """A user's plant: n uncoupled x'' + 2 zeta w x' + w^2 x = u + xi on unit masses."""

    n: int
    stiffness: float = 100.0
    damping: float = 1.0
    kind: str = "revolute"

    @property
    def joint_names(self):
        return tuple(f"mass{i}" for i in range(self.n))

    @property
    def joint_types(self):
        return (self.kind,) * self.n

    @property
    def effort_limit(self):
        return np.full(self.n, 50.0)

    @property
    def home(self):
        return np.zeros(self.n)

    def mass_matrix(self, q):
        return np.eye(self.n)

    def potential_force(self, q):
        return self.stiffness * q

    def damping_matrix(self, v):
        return np.zeros((self.n, self.n))

    def bias_force(self, q, v):
        return self.damping * v + self.stiffness * q

    def base_coupling(self, q):
        return np.zeros((self.n, 6))


@dataclass(frozen=True)
class Force:
    """A user's noise input: one channel a joint, straight onto it."""

    channels: int

    def matrix(self, arm, q):
        return np.eye(self.channels)


@dataclass(frozen=True)
class Spring:
    """A user's law: u = -k (q - q_d) - d v; none at all by default."""

    k: float = 0.0
    d: float = 0.0

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        return {"u": -self.k * (q - desired.q) - self.d * v}, state


def test_the_dataset_holds_what_it_should(loop, engine):
    dataset = simulate(loop, 0.05, seed=3, path=5, engine=engine)
    assert isinstance(dataset, xr.Dataset)
    assert set(dataset.data_vars) == ALWAYS
    for name in ("q", "q_d", "v", "u"):
        assert dataset[name].dims == ("time", "joint")
        assert dataset[name].shape == (51, 2)
        assert dataset[name].long_name
        assert np.all(np.isfinite(dataset[name]))
    units = {name: dataset[name].units for name in [*ALWAYS, "time"]}
    assert units == {
        "q": "rad",
        "q_d": "rad",
        "v": "rad/s",
        "u": "N m",
        "ote": "rad",
        "diverged_at": "s",
        "time": "s",
    }
    assert dataset.ote.dims == ("time",)
    assert dataset.diverged_at.dims == ()
    assert np.isnan(dataset.diverged_at)
    assert dataset.joint.values.tolist() == list(loop.arm.joint_names)
    assert dataset.joint_type.values.tolist() == list(loop.arm.joint_types)


def test_the_attributes_tell_how_to_run_it_again(loop, engine):
    attrs = simulate(loop, 0.01, seed=3, path=5, engine=engine).attrs
    assert (attrs["seed"], attrs["path"], attrs["duration"]) == (3, 5, 0.01)
    assert attrs["ftcfa_version"] == ftcfa.__version__
    experiment = json.loads(attrs["experiment"])
    assert experiment["arm"]["robot"] == "double_pendulum"
    assert experiment["controller"]["gains"]["kappa"] == 0.6
    assert experiment["q0"] == [-0.1, 0.25]
    assert experiment["v0"] == [-0.3, 0.45]
    assert experiment["period"] == 1e-3


def test_values_are_where_they_belong(loop, engine):
    dataset = simulate(loop, 0.1, engine=engine)
    np.testing.assert_array_equal(dataset.q[0], [-0.1, 0.25])
    np.testing.assert_array_equal(dataset.v[0], [-0.3, 0.45])
    t = dataset.time.values
    np.testing.assert_allclose(t, np.arange(101) * 1e-3, rtol=1e-15)
    expected = np.column_stack([1.5 * np.sin(t), np.sin(2.0 * t)])
    np.testing.assert_allclose(dataset.q_d, expected, rtol=0, atol=1e-15)
    error = dataset.q.values - dataset.q_d.values
    np.testing.assert_allclose(dataset.ote, np.hypot(*error.T), rtol=1e-14)
    np.testing.assert_allclose(  # Euler-Maruyama: q moves with v
        np.diff(dataset.q, axis=0), 1e-3 * dataset.v.values[:-1], rtol=0, atol=1e-15
    )


def test_time_zero_alone(loop, engine):
    dataset = simulate(loop, 0, engine=engine)
    assert dataset.time.values.tolist() == [0.0]
    np.testing.assert_array_equal(dataset.q, [[-0.1, 0.25]])


@pytest.mark.parametrize(("duration", "samples"), [(0.0104, 11), (0.0106, 12), (0.3, 301)])
def test_the_duration_is_rounded_to_samples(loop, duration, samples):
    assert simulate(loop, duration).sizes["time"] == samples


@pytest.mark.parametrize("every", [1, 2, 7, 50, 1000])
def test_recording_less_leaves_samples_out_and_changes_none(loop, engine, every):
    all_samples = simulate(loop, 0.1, engine=engine)
    some = simulate(loop, 0.1, record_every=every, engine=engine)
    xr.testing.assert_equal(some, all_samples.isel(time=slice(None, None, every)))


def test_signals_on_request(loop, engine):
    everything = simulate(loop, 0.01, signals="all", engine=engine)
    assert set(everything.data_vars) == ALWAYS | FTCF_SIGNALS | TOOL | {"u_command", "u_wanted"}
    some = simulate(loop, 0.01, signals=["rho", "theta", "q"], engine=engine)
    assert set(some.data_vars) == ALWAYS | {"rho", "theta"}
    assert set(simulate(loop, 0.01, signals="rho", engine=engine).data_vars) == ALWAYS | {"rho"}
    for name in some.data_vars:
        np.testing.assert_array_equal(some[name], everything[name])
    assert everything.theta.dims == ("time",)
    for name in FTCF_SIGNALS - {"theta"}:
        assert everything[name].dims == ("time", "joint")
        assert everything[name].units
    np.testing.assert_array_equal(everything.z1, everything.q - everything.q_d)


def test_an_unknown_signal_lists_the_known_ones(loop):
    with pytest.raises(UnknownNameError, match=r"signal 'torque'.*one of: .*alpha.*u_command"):
        simulate(loop, 0.01, signals=["rho", "torque"])


@pytest.mark.parametrize("duration", [-1.0, np.nan, np.inf, "1 s", None, True])
def test_bad_durations_are_refused(loop, duration):
    with pytest.raises(ParameterError, match=r"duration: .*, expected a number >= 0 \[s\]"):
        simulate(loop, duration)


@pytest.mark.parametrize("name", ["seed", "path"])
@pytest.mark.parametrize("value", [-1, 2**64, 1.0, "1", None, True])
def test_bad_seeds_and_paths_are_refused(loop, name, value):
    with pytest.raises(ParameterError, match=rf"{name}: .*an integer from 0 to 2\^64 - 1"):
        simulate(loop, 0.01, **{name: value})


@pytest.mark.parametrize("value", [0, -1, 2.0, 1.5, "2", None, True, np.nan])
def test_bad_recording_intervals_are_refused(loop, value):
    with pytest.raises(ParameterError, match=r"record_every: .*, expected an integer >= 1"):
        simulate(loop, 0.01, record_every=value)


def test_one_path_is_one_path_and_another_another(loop, engine):
    def final(**which):
        return simulate(loop, 0.1, engine=engine, **which).q.values

    again = final(seed=1, path=2)
    np.testing.assert_array_equal(final(seed=1, path=2), again)
    for other in ({"seed": 1, "path": 3}, {"seed": 2, "path": 2}, {"seed": 2, "path": 1}):
        assert np.all(final(**other)[2:] != again[2:])
    huge = final(seed=2**64 - 1, path=2**64 - 1)
    assert np.all(np.isfinite(huge))
    assert np.all(huge[2:] != again[2:])


@pytest.mark.parametrize("substeps", [1, 2])
def test_a_longer_run_continues_a_shorter_one(engine, substeps):
    """Across the engine's own chunks of samples too: 5000 are more than one."""
    vibration = Vibration(Force(1), WhiteNoise(1.0))
    loop = ClosedLoop(
        Oscillators(1), Spring(), Constant([0.0]), vibration, period=1e-3, substeps=substeps
    )
    long, short = (simulate(loop, t, engine=engine) for t in (5.0, 4.0))
    xr.testing.assert_equal(long.isel(time=slice(0, 4001)), short)


def test_noise_belongs_to_time_and_not_to_the_substeps_of_a_sample(engine):
    """Without control, 4 substeps of 1 ms are 4 samples of 1 ms, deviate for deviate."""
    plant, vibration = Oscillators(2), Vibration(Force(2), WhiteNoise(1.0))
    settings = {"reference": Constant([0.0, 0.0]), "vibration": vibration}
    coarse = ClosedLoop(plant, Spring(), period=4e-3, substeps=4, **settings)
    fine = ClosedLoop(plant, Spring(), period=1e-3, **settings)
    a = simulate(coarse, 0.2, engine=engine)
    b = simulate(fine, 0.2, record_every=4, engine=engine)
    np.testing.assert_allclose(a.q, b.q, rtol=ROUNDING, atol=0)


def test_the_integrator_is_a_choice(engine):
    """From rest at x0 = 1, one step: Euler-Maruyama leaves x where it is, the other moves it."""
    for integrator, x in [("euler-maruyama", 1.0), ("semi-implicit", 1.0 - 1e-3 * 1e-3 * 100.0)]:
        loop = ClosedLoop(
            Oscillators(1), Spring(), Constant([0.0]), integrator=integrator, q0=[1.0]
        )
        dataset = simulate(loop, 1e-3, engine=engine)
        assert dataset.q.values[1, 0] == pytest.approx(x, rel=1e-14)


@pytest.mark.parametrize("integrator", ["euler-maruyama", "semi-implicit"])
def test_shaken_oscillators_have_the_variance_of_theory(engine, integrator):
    """20 oscillators on 50 paths, at t = 0.5: 0.0020343, Euler-Maruyama's own 2.4 % more."""
    loop = ClosedLoop(
        Oscillators(20),
        Spring(),
        Constant(np.zeros(20)),
        Vibration(Force(20), WhiteNoise(1.0)),
        integrator=integrator,
    )
    ends = simulate_paths(loop, 50, 0.5, record_every=500, engine=engine).q.values[:, -1]
    variance = 0.0020343 * (1.024 if integrator == "euler-maruyama" else 1.002)
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = stats.chi2.ppf([tail, 1.0 - tail], ends.size) / ends.size
    assert low < np.mean(ends**2) / variance < high
    between_joints = np.corrcoef(ends.T)[np.triu_indices(20, 1)]
    assert np.max(np.abs(between_joints)) < SIGMAS / math.sqrt(50)
    between_paths = np.corrcoef(ends)[np.triu_indices(50, 1)]
    assert np.mean(between_paths) == pytest.approx(0.0, abs=SIGMAS / math.sqrt(50 * 49 / 2 * 20))


def test_a_free_pendulum_keeps_its_energy(engine):
    """To 1 % of the energy of the swing over five seconds, with the semi-implicit integrator."""
    arm = PaperPendulum()
    loop = ClosedLoop(
        arm, Spring(), Constant([0.0, 0.0]), q0=[1.0, 0.5], integrator="semi-implicit"
    )
    dataset = simulate(loop, 5.0, engine=engine)
    q, v = dataset.q.values, dataset.v.values
    (m1, m2), (l1, l2) = arm.m, arm.l
    kinetic = 0.5 * (m1 + m2) * (l1 * v[:, 0]) ** 2 + 0.5 * m2 * (l2 * v[:, 1]) ** 2
    kinetic += m2 * l1 * l2 * np.cos(q[:, 1] - q[:, 0]) * v[:, 0] * v[:, 1]
    heights = (m1 + m2) * l1 * (1 - np.cos(q[:, 0])) + m2 * l2 * (1 - np.cos(q[:, 1]))
    energy = kinetic + arm.g * heights
    assert np.max(kinetic) > 0.5 * energy[0]  # it does swing
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 0.01


def test_a_users_law_tracks_a_users_plant(engine):
    """u = -k (x - x_d) - d v with Oscillators: the static answer x = k x_d / (k + 100)."""
    loop = ClosedLoop(Oscillators(1), Spring(k=300.0, d=40.0), Constant([0.1]))
    dataset = simulate(loop, 2.0, engine=engine)
    assert dataset.q.values[-1, 0] == pytest.approx(0.1 * 300.0 / 400.0, rel=1e-6)


def test_the_papers_law_controls_a_users_plant(engine):
    plant = Oscillators(1)
    loop = ClosedLoop(plant, FTCF(plant, compensation="bias"), Sinusoid([0.2], [2.0]))
    dataset = simulate(loop, 3.0, signals="all", engine=engine)
    assert dataset.ote[-1000:].max() < 1e-3
    assert dataset.theta.dims == ("time",)  # not taken for a signal of the one joint
    assert dataset.rho.dims == ("time", "joint")


@dataclass(frozen=True)
class Chatty(Spring):
    """A user's law with signals of its own shapes and a state that it branches on."""

    seen: list = field(default_factory=list, compare=False)

    def init(self, measured, desired):
        return np.zeros(3)

    def step(self, state, measured, desired, period):
        signals, _ = super().step((), measured, desired, period)
        if measured.q[0] > 0:  # no trace can follow this
            state = state + 1.0
        return {**signals, "spectrum": state, "gain": np.eye(2), "sum": np.sum(measured.q)}, state


def test_a_users_law_may_branch_and_signal_what_it_likes():
    loop = ClosedLoop(Oscillators(2), Chatty(), Constant([0.0, 0.0]), q0=[0.1, -0.1])
    dataset = simulate(loop, 0.02, signals="all", engine="interpreted")
    assert dataset["spectrum"].dims == ("time", "spectrum_0")
    assert dataset["gain"].dims == ("time", "gain_0", "gain_1")
    assert dataset["sum"].dims == ("time",)
    np.testing.assert_array_equal(dataset["spectrum"][:, 0], np.arange(1, 22))


@pytest.mark.parametrize("u", [np.zeros(3), np.zeros((2, 1)), 0.0])
def test_a_law_with_a_torque_of_the_wrong_shape_is_refused(u):
    class Wrong(Spring):
        def step(self, state, measured, desired, period):
            return {"u": u}, state

    loop = ClosedLoop(PaperPendulum(), Wrong(), Constant([0.0, 0.0]))
    with pytest.raises(ShapeError, match=r"u of the controller: shape .*, expected \(2,\)"):
        simulate(loop, 0.01, engine="interpreted")


def test_the_units_of_prismatic_joints(engine):
    plant = Oscillators(2, kind="prismatic")
    loop = ClosedLoop(plant, FTCF(plant), Constant([0.0, 0.0]))
    dataset = simulate(loop, 0.01, signals="all", engine=engine)
    assert dataset.q.units == dataset.ote.units == "rad (prismatic joints: m)"
    assert dataset.v.units == "rad/s (prismatic joints: m/s)"
    assert dataset.u.units == "N m (prismatic joints: N)"
    assert dataset.theta.units == "1"


def test_the_torque_that_acts_is_within_the_limits(engine):
    arm = load_arm("double_pendulum", gravity=9.8, effort_limit=3.0)
    loop = ClosedLoop(arm, FTCF(arm), Sinusoid([1.5, 1.0], [1.0, 2.0]))
    dataset = simulate(loop, 1.0, signals=["u_command"], engine=engine)
    assert np.abs(dataset.u).max() == 3.0
    assert np.abs(dataset.u_command).max() > 10.0
    np.testing.assert_array_equal(dataset.u, np.clip(dataset.u_command, -3.0, 3.0))


def test_a_wrong_nominal_arm_still_tracks(engine):
    """The controller knows only the nominal UR5; the true one was drawn with 10 % in mass."""
    nominal = load_arm("ur5")
    true = nominal.perturbed(np.random.default_rng(4))
    change = true.potential_force(true.home) - nominal.potential_force(nominal.home)
    assert np.max(np.abs(change)) > 0.5  # N m that the compensation is wrong by
    reference = Sinusoid(0.3, offset=nominal.home)
    dataset = simulate(
        ClosedLoop(true, FTCF(nominal, compensation="bias"), reference), 3.0, engine=engine
    )
    assert dataset.ote[1500:].max() < 0.02


ESCAPE = 50.0
"""Rate of the unstable plant x'' = rate^2 x [1/s]."""


def escaping(**settings):
    plant = Oscillators(2, stiffness=-(ESCAPE**2), damping=0.0)
    return ClosedLoop(plant, Spring(), Constant([0.0, 0.0]), q0=[1.0, 0.1], **settings)


def test_a_path_that_diverges_is_marked_with_its_time(engine):
    """x = cosh(50 t): x' = 50 sinh(50 t) passes the bound at asinh(bound/50)/50 = 0.12 s."""
    loop = escaping(period=1e-4)
    dataset = simulate(loop, 0.3, signals="all", engine=engine)
    diverged_at = float(dataset.diverged_at)
    assert diverged_at == pytest.approx(math.asinh(DIVERGED / ESCAPE) / ESCAPE, rel=0.01)
    before = dataset.time < diverged_at - 1e-9
    for name in ("q", "v", "u", "u_command"):
        assert np.all(np.isfinite(dataset[name][before]))
        assert np.all(np.isnan(dataset[name][~before]))
    assert np.all(np.isnan(dataset.ote[~before]))
    assert np.abs(dataset.v[before]).max() < DIVERGED
    assert dataset.sizes["time"] == 3001


def test_divergence_does_not_depend_on_what_is_recorded(engine):
    full, sparse = (
        simulate(escaping(), 0.3, record_every=every, engine=engine) for every in (1, 13)
    )
    assert float(full.diverged_at) == float(sparse.diverged_at)
    xr.testing.assert_equal(sparse, full.isel(time=slice(None, None, 13)))


def test_growth_beyond_all_numbers_within_one_sample_is_a_divergence(engine):
    """60 substeps of factor 6e5 overflow: infinities and NaN appear, and nothing is raised."""
    plant = Oscillators(2, stiffness=-1e14, damping=0.0)
    loop = ClosedLoop(plant, Spring(), Constant([0.0, 0.0]), q0=[1.0, 0.1], substeps=60, period=1.0)
    dataset = simulate(loop, 3.0, engine=engine)
    assert float(dataset.diverged_at) == 1.0
    assert np.all(np.isfinite(dataset.q[0]))
    assert np.all(np.isnan(dataset.q[1:]))


class Counter(Spring):
    """Counts its samples from the last start on; from the fourth on it asks for no number."""

    def init(self, measured, desired):
        q = measured.q
        return (q - desired.q,)

    def step(self, state, measured, desired, period):
        (count,) = state
        u = np.where(count > 3.5, np.inf - np.inf, count)
        return {"u": u, "count": count}, (count + 1.0,)


def test_a_law_that_asks_for_no_number_starts_anew(engine):
    """Zero torque at that sample; at the next one, init makes a state of the measurement."""
    plant = Oscillators(1, stiffness=0.0, damping=0.0)
    loop = ClosedLoop(plant, Counter(), Constant([0.0]), q0=[1.0], period=0.25)
    dataset = simulate(loop, 2.0, engine=engine, signals=["count", "u_command"])
    assert np.isnan(float(dataset.diverged_at))
    q, v, count, expected = 1.0, 0.0, 1.0, []
    for _ in range(len(dataset.time)):
        u = count if count <= 3.5 else 0.0
        expected.append((q, count, u))
        q, v, count = q + 0.25 * v, v + 0.25 * u, count + 1.0 if count <= 3.5 else np.nan
        count = q if np.isnan(count) else count
    for name, values in zip(("q", "count", "u"), zip(*expected, strict=True), strict=True):
        np.testing.assert_allclose(dataset[name][:, 0], values, rtol=1e-12)
    assert np.isnan(dataset.u_command).any()


def test_other_paths_are_not_started_anew(engine):
    """Paths whose law asks for no number at other times, side by side and alone: the same bits."""
    plant = Oscillators(1, stiffness=0.0, damping=0.0)
    loop = ClosedLoop(plant, Counter(), Constant([0.0]), q0=[1.0], period=0.25)
    starts = np.linspace(0.0, 3.0, 11)[:, None]
    together = simulate_paths(loop, 11, 2.0, vary={"q0": starts}, engine=engine)
    for i, start in enumerate(starts):
        alone = simulate(replace(loop, q0=start), 2.0, engine=engine)
        np.testing.assert_array_equal(together.q[i], alone.q)


def test_an_arm_that_diverges_raises_nothing(engine):
    """The paper's pendulum, and Pinocchio under it, on numbers that leave all bounds."""
    arm = load_arm("double_pendulum", effort_limit=1e9)
    loop = ClosedLoop(arm, FTCF(arm, Gains(c2=1e5)), Constant([0.0, 0.0]), q0=[1.0, -1.0])
    dataset = simulate(loop, 1.0, engine=engine)
    assert 0.0 < float(dataset.diverged_at) < 1.0


def test_a_start_beyond_the_bound_has_diverged_at_zero(engine):
    loop = ClosedLoop(PaperPendulum(), Spring(), Constant([0.0, 0.0]), v0=[2 * DIVERGED, 0.0])
    dataset = simulate(loop, 0.01, engine=engine)
    assert float(dataset.diverged_at) == 0.0
    assert np.all(np.isnan(dataset.q))
