"""The compiled engine against the interpreted one, and against itself in any division of work."""

import subprocess
import sys
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ExplicitFilter,
    Gains,
    ImplicitFilter,
    PaperPendulum,
    PaperPendulumInput,
    RBFNetwork,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.engine import compiled
from ftcfa.engine.compiled import run_compiled
from ftcfa.engine.compiler.target import host_target
from ftcfa.streams import PLANT_NOISE, standard_normals

from .loops import FULL_VARPI, PI, Spring, gantry, masses, panda_with_gripper, shaken
from .targets import TARGETS

pytestmark = pytest.mark.filterwarnings("error:running interpreted")  # no silent fall back

AGREEMENT = 1e-9
"""Absolute, or relative to the largest value of the signal where that is above 1: what compiled
and interpreted may differ by over a second. Rounding alone gives 1e-16 to 1e-10."""
ULP = 1e-15
SEPARATION = 100
"""By so many times may the engines be further apart than two starts that differ by ULP."""


def assert_engines_agree(loop, duration, tolerance=AGREEMENT, seed=3, path=5):
    ours, theirs = (
        simulate(loop, duration, seed=seed, path=path, signals="all", engine=engine)
        for engine in ("compiled", "interpreted")
    )
    assert ours.attrs["engine"] == "compiled"
    assert set(ours.data_vars) == set(theirs.data_vars)
    for name in theirs.data_vars:
        a, b = ours[name].values, np.asarray(theirs[name].values, dtype=float)
        assert a.shape == b.shape, name
        np.testing.assert_array_equal(np.isnan(a), np.isnan(b), err_msg=name)
        scale = max(1.0, np.max(np.abs(b), initial=0.0, where=np.isfinite(b)))
        assert np.all(np.isnan(b) | (np.abs(a - b) <= tolerance * scale)), name


NAMED_ARMS = {
    "double_pendulum": lambda _: shaken(load_arm("double_pendulum"), "xz"),
    "panda": lambda _: shaken(load_arm("panda")),
    "ur5": lambda _: shaken(load_arm("ur5"), "z", 0.3, "amplitude"),
    "kinova": lambda _: shaken(load_arm("kinova"), "xyz", FULL_VARPI),
    "xarm7, friction": lambda _: shaken(load_arm("xarm7"), "yx", [0.2, 0.1]),
    "gantry, prismatic": lambda folder: shaken(gantry(folder), "xy"),
    "panda's gripper, mimic": lambda _: shaken(panda_with_gripper()),
    "baxter, branched": lambda _: shaken(load_arm("baxter")),
}


@pytest.mark.parametrize("name", NAMED_ARMS)
def test_engines_agree_over_a_second(name, tmp_path):
    assert_engines_agree(NAMED_ARMS[name](tmp_path), 1.0)


@pytest.mark.parametrize(
    ("name", "compensation", "integrator", "substeps"),
    [
        ("panda", "bias", "semi-implicit", 4),
        ("ur5", "gravity", "euler-maruyama", 4),
        ("xarm7, friction", "bias", "semi-implicit", 1),
        ("kinova", "gravity", "semi-implicit", 1),
        ("gantry, prismatic", "bias", "semi-implicit", 4),
        ("panda's gripper, mimic", "bias", "euler-maruyama", 1),
    ],
)
def test_engines_agree_on_arms_with_options(name, compensation, integrator, substeps, tmp_path):
    loop = NAMED_ARMS[name](tmp_path)
    controller = FTCF(loop.arm, compensation=compensation, filter="explicit")
    assert_engines_agree(
        ClosedLoop(
            loop.arm,
            controller,
            loop.reference,
            loop.vibration,
            period=5e-4,
            substeps=substeps,
            integrator=integrator,
            q0=loop.arm.home + 0.05,
            v0=np.full(loop.arm.n, -0.1),
        ),
        0.1,
    )


PENDULUM = load_arm("double_pendulum", gravity=9.8)
NOISE = {
    "no noise": None,
    "x": Vibration(BaseAcceleration("x"), WhiteNoise(0.1)),
    "zx": Vibration(BaseAcceleration("zx"), WhiteNoise([0.1, 0.3])),
    "xyz, full": Vibration(BaseAcceleration("xyz"), WhiteNoise(FULL_VARPI)),
    "xz, amplitude": Vibration(BaseAcceleration("xz"), WhiteNoise(0.3, "amplitude")),
    "printed": Vibration(PaperPendulumInput(), WhiteNoise(0.1)),
    "printed, full amplitude": Vibration(
        PaperPendulumInput(), WhiteNoise([[0.3, 0.1], [0.1, 0.2]], "amplitude")
    ),
}
PLANTS = {
    "urdf": PENDULUM,
    "corrected": PaperPendulum(),
    "as printed": PaperPendulum(as_printed=True),
}
OPTIONS = {
    "noise": list(NOISE),
    "filter": [ImplicitFilter(), ExplicitFilter(30.0, 20.0), ImplicitFilter(60.0, 20.0)],
    "compensation": ["none", "gravity", "bias"],
    "plant": list(PLANTS),
    "network": [RBFNetwork(), RBFNetwork(1), RBFNetwork(17, 2.0, 1.0)],
    "integrator": ["euler-maruyama", "semi-implicit"],
    "substeps": [1, 4],
    "gains": [Gains(), Gains(5.0, 12.0, 3.0, 0.7, 0.6, 8.0, 4.0, 0.5)],
    "kappa": [0.6, 1.0],
}


def covering(options, seed=0):
    """Choices in which every pair of values of two options meets at least once."""
    rng, names = np.random.default_rng(seed), list(options)
    sizes = {name: len(values) for name, values in options.items()}
    missing = {
        (a, i, b, j)
        for k, a in enumerate(names)
        for b in names[k + 1 :]
        for i in range(sizes[a])
        for j in range(sizes[b])
    }

    def met(row):
        return {pair for pair in missing if row[pair[0]] == pair[1] and row[pair[2]] == pair[3]}

    while missing:
        rows = [{name: int(rng.integers(sizes[name])) for name in names} for _ in range(50)]
        best = max(rows, key=lambda row: len(met(row)))
        missing -= met(best)
        yield {name: options[name][i] for name, i in best.items()}


@pytest.mark.parametrize("choice", list(covering(OPTIONS)), ids=lambda choice: str(choice["noise"]))
def test_engines_agree_with_every_pair_of_options(choice):
    gains = Gains(**{**vars(choice["gains"]), "kappa": choice["kappa"]})
    controller = FTCF(PENDULUM, gains, choice["filter"], choice["compensation"], choice["network"])
    loop = ClosedLoop(
        PLANTS[choice["plant"]],
        controller,
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        NOISE[choice["noise"]],
        substeps=choice["substeps"],
        integrator=choice["integrator"],
        q0=[-0.1, 0.25],
        v0=[-0.3, 0.45],
    )
    assert_engines_agree(loop, 0.1)


def test_the_explicit_filter_limit_cycles_alike_in_both_engines():
    # At 1 ms and the paper's gains its sign() leaps every few samples: still no separation.
    assert_engines_agree(shaken(PENDULUM, "xz", controller=FTCF(PENDULUM, filter="explicit")), 1.0)


def noise_free(kappa=0.6, shift=0.0):
    """The paper's pendulum without its noise, from the paper's start or one beside it."""
    return ClosedLoop(
        PENDULUM,
        FTCF(PENDULUM, Gains(kappa=kappa)),
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        q0=[-0.1 + shift, 0.25],
        v0=[-0.3, 0.45],
    )


def test_without_noise_the_engines_agree_where_the_law_is_smooth():
    assert_engines_agree(noise_free(kappa=1.0), 1.0)
    assert_engines_agree(noise_free(kappa=0.6), 0.3)


def test_without_noise_the_engines_part_only_as_two_starts_an_ulp_apart_do():
    # |s1|^0.6 has infinite slope at zero, where s1 stays until the filter leaves its sliding mode
    # at 0.33 s: rounding grows to 5e-7 rad there, between engines as between nearby starts.
    truth = simulate(noise_free(), 1.0, engine="interpreted").q
    nearby = [simulate(noise_free(shift=x), 1.0, engine="interpreted").q for x in (ULP, -ULP)]
    apart = max(float(np.abs(q - truth).max()) for q in nearby)
    assert np.abs(simulate(noise_free(), 1.0).q - truth).max() <= SEPARATION * apart


def test_a_users_law_and_plant_are_compiled():
    loop = masses(3, PI(), substeps=2, period=0.01, v0=[0.1, -0.2, 0.3])
    assert_engines_agree(loop, 1.0)
    pendulum = ClosedLoop(PENDULUM, PI(), Sinusoid([0.3, 0.2]), NOISE["zx"])
    assert_engines_agree(pendulum, 0.2)
    result = simulate(pendulum, 0.01, signals="all")
    assert result["corner"].shape == (11, 2, 2)
    assert result["energy"].shape == (11,)
    np.testing.assert_array_equal(result["count"], np.arange(11))
    np.testing.assert_array_equal(result["gain"], np.tile([5.0, 20.0], (11, 1)))
    np.testing.assert_array_equal(result["corner"][:, 0], result["q"])
    np.testing.assert_array_equal(result["fast"], np.abs(result["v"]) > 0.1)


def test_a_law_that_answers_with_a_constant_is_compiled():
    class Zero(Spring):
        def step(self, state, measured, desired, period):
            return {"u": np.zeros(2)}, state

    result = simulate(masses(law=Zero()), 0.01)
    assert result.attrs["engine"] == "compiled"
    np.testing.assert_array_equal(result["u"], 0.0)


# Any division of the work


@pytest.fixture(scope="module")
def loop():
    return shaken(PENDULUM, "xz", substeps=2)


@pytest.fixture(scope="module")
def varied():
    """A thousand different robots and controllers."""
    rng = np.random.default_rng(1)
    return {
        "q0": rng.uniform(-0.5, 0.5, (1000, 2)),
        "controller.gains.c1": rng.uniform(3.0, 9.0, 1000),
        "arm.inertias": PENDULUM.inertias * rng.uniform(0.9, 1.1, (1000, 1, 1)),
    }


@pytest.fixture(scope="module")
def thousand(loop, varied):
    """A thousand paths at once."""
    return simulate_paths(loop, 1000, 0.05, vary=varied, record_every=10)


def of_paths(varied, chosen):
    return {name: values[chosen] for name, values in varied.items()}


def assert_identical(some, thousand, chosen):
    for name in ("q", "v", "u", "ote", "diverged_at"):
        np.testing.assert_array_equal(some[name], thousand[name].values[chosen], err_msg=name)
    np.testing.assert_array_equal(some["path"], np.asarray(chosen))


@pytest.mark.parametrize("path", [0, 1, 7, 8, 499, 999])
def test_a_path_is_bitwise_the_same_alone(loop, varied, thousand, path):
    alone = simulate_paths(loop, [path], 0.05, vary=of_paths(varied, [path]), record_every=10)
    assert_identical(alone, thousand, [path])


def test_simulate_is_one_of_simulate_paths(loop):
    many = simulate_paths(loop, 20, 0.05)
    one = simulate(loop, 0.05, path=13)
    for name in ("q", "v", "u"):
        np.testing.assert_array_equal(one[name], many[name][13])
    assert one.attrs["path"] == 13


@pytest.mark.parametrize("threads", [1, 2, 7, 200])
def test_paths_are_bitwise_the_same_on_any_threads(loop, varied, thousand, threads):
    again = simulate_paths(loop, 1000, 0.05, vary=varied, record_every=10, threads=threads)
    assert_identical(again, thousand, np.arange(1000))


def test_paths_are_bitwise_the_same_in_any_lane_and_order(loop, varied, thousand):
    order = np.random.default_rng(2).permutation(1000)
    again = simulate_paths(loop, order, 0.05, vary=of_paths(varied, order), record_every=10)
    assert_identical(again, thousand, order)


@pytest.mark.parametrize("chunk", [1, 3, 9, 13, 64])
def test_paths_are_bitwise_the_same_in_any_chunk_and_padding(loop, varied, thousand, chunk):
    for start in (0, 5, 900):
        chosen = np.arange(start, start + chunk)
        some = simulate_paths(loop, chosen, 0.05, vary=of_paths(varied, chosen), record_every=10)
        assert_identical(some, thousand, chosen)


def test_the_same_path_twice_is_twice_the_same(loop):
    twice = simulate_paths(loop, [4, 4, 9, 4], 0.02)
    for i in (1, 3):
        np.testing.assert_array_equal(twice.q[0], twice.q[i])
    assert np.any(twice.q[0] != twice.q[2])


@pytest.mark.parametrize("ticks", [1, 7, 50, 51, 10**6])
def test_paths_are_bitwise_the_same_whatever_the_ticks_per_call(
    loop, varied, thousand, ticks, monkeypatch
):
    monkeypatch.setattr(compiled, "TICKS_PER_CALL", ticks)
    chosen = np.arange(10)
    some = simulate_paths(loop, chosen, 0.05, vary=of_paths(varied, chosen), record_every=10)
    assert_identical(some, thousand, chosen)


def test_a_longer_run_begins_as_a_shorter_one(loop):
    short, long = (simulate_paths(loop, 3, duration) for duration in (0.02, 0.03))
    np.testing.assert_array_equal(short.u, long.u[:, :21])


def test_recording_less_changes_nothing(loop):
    every, some = (simulate_paths(loop, 3, 0.05, record_every=k) for k in (1, 7))
    for name in ("q", "v", "u"):
        np.testing.assert_array_equal(some[name], every[name][:, ::7])
    np.testing.assert_array_equal(some.time, every.time[::7])


def test_seeds_and_paths_give_different_noise(loop):
    ends = [
        simulate(loop, 0.02, seed=seed, path=path).v[-1].values.tobytes()
        for seed in (0, 1, 2**64 - 1)
        for path in (0, 1, 2**64 - 1)
    ]
    assert len(set(ends)) == 9


def test_simulations_at_the_same_time_are_independent():
    # Four callers trace, compile and run at once, each another program.
    def one(c2):
        arm = load_arm("double_pendulum")
        return simulate(shaken(arm, "xz", controller=FTCF(arm, Gains(c2=c2))), 0.05).u.values

    gains = [21.0, 22.0, 23.0, 24.0]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(one, gains))
    for c2, u in zip(gains, together, strict=True):
        np.testing.assert_array_equal(u, one(c2))


# Noise


@pytest.mark.parametrize("channels", [1, 2, 3, 5])
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_noise_is_that_of_the_streams(channels, substeps):
    # Unit masses and unit steps: each step adds its deviates to v, and nothing else does.
    seed, paths, ticks = 2**64 - 5, [0, 3, 2**63, 2**64 - 1], 12
    loop = masses(channels, period=float(substeps), substeps=substeps)
    v = simulate_paths(loop, paths, ticks * substeps, seed=seed).v.values
    for i, path in enumerate(paths):
        steps = range(ticks * substeps)
        normals = standard_normals(seed, path, PLANT_NOISE, steps, channels)
        sums = normals.reshape(ticks, substeps, channels).sum(axis=1)
        np.testing.assert_allclose(np.diff(v[i], axis=0), sums, rtol=0, atol=1e-13)


# Vectors


@pytest.fixture(scope="module")
def reference_run(loop):
    paths = np.arange(19, dtype=np.uint64)
    return run_compiled(loop, 101, 5, 0, paths, ["q", "v", "u", "theta"], {})


@pytest.mark.parametrize("target", TARGETS.values(), ids=list(TARGETS))
def test_every_target_gives_the_same_bits(loop, reference_run, target):
    """Any number of lanes, with and without AVX-512, AVX2 and fused multiply-adds in hardware."""
    paths = np.arange(19, dtype=np.uint64)
    names = ["q", "v", "u", "theta"]
    signals, death, _ = run_compiled(loop, 101, 5, 0, paths, names, {}, target=target)
    assert np.all(np.isnan(death))
    for name in names:
        np.testing.assert_array_equal(signals[name], reference_run[0][name])


@pytest.mark.parametrize("lanes", [1, 2, 16])
def test_lanes_of_any_width_run_paths_alike(loop, lanes):
    def run(paths):
        numbers = np.array(paths, dtype=np.uint64)
        return run_compiled(loop, 21, 1, 0, numbers, ["v"], {}, target=host_target(lanes))[0]["v"]

    many = run(range(35))
    np.testing.assert_array_equal(run([33]), many[33:34])
    np.testing.assert_array_equal(run([34, 2, 17])[1:], many[[2, 17]])


# Ends


def test_no_paths_at_all(loop):
    for paths in (0, []):
        none = simulate_paths(loop, paths, 0.01, signals="all")
        assert none.sizes["path"] == 0
        assert none.sizes["time"] == 11
        assert none.q.shape == (0, 11, 2)
        assert none.diverged_at.shape == (0,)
    vary = {"controller.gains.c1": [], "arm.inertias": np.zeros((0, *PENDULUM.inertias.shape))}
    assert simulate_paths(loop, 0, 0.01, vary=vary).q.shape == (0, 11, 2)


def test_one_sample(loop):
    result = simulate_paths(loop, 5, 0.0, signals="alpha")
    assert result.sizes["time"] == 1
    np.testing.assert_array_equal(result.q[:, 0], np.tile(PENDULUM.home, (5, 1)))
    truth = simulate(loop, 0.0, signals="alpha", engine="interpreted")
    np.testing.assert_allclose(result.alpha[4], truth.alpha, rtol=1e-14)


@pytest.fixture
def runaway():
    """Unit masses under u = -k q, without noise: q grows without bound where k < 0."""
    return masses(law=Spring(1.0), vibration=None, period=0.01, substeps=3, v0=[1.0, 0.5])


STIFFNESS = [4.0, -900.0, 9.0, -400.0, 1.0, -2500.0, 0.0, 16.0, -100.0, 25.0, -1e5]


def test_a_path_that_diverges_ends_as_interpreted(runaway):
    vary = {"controller.k": STIFFNESS}
    for record_every in (1, 7):
        ours, theirs = (
            simulate_paths(runaway, 11, 1.5, vary=vary, record_every=record_every, engine=engine)
            for engine in ("compiled", "interpreted")
        )
        np.testing.assert_array_equal(ours.diverged_at, theirs.diverged_at)
        diverged = np.isfinite(theirs.diverged_at.values)
        np.testing.assert_array_equal(diverged, np.array(STIFFNESS) < -50.0)
        for name in ("q", "v", "u", "ote"):
            np.testing.assert_array_equal(np.isnan(ours[name]), np.isnan(theirs[name]))
            np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-9, atol=1e-9)
        for path in np.flatnonzero(diverged):
            after = ours.time.values >= ours.diverged_at.values[path]
            assert np.isnan(ours.q.values[path, after]).all()
            assert np.isfinite(ours.q.values[path, ~after]).all()


def test_a_diverging_path_leaves_its_neighbours_unchanged(runaway):
    calm = [k if k >= 0 else 2.0 for k in STIFFNESS]
    wild, still = (
        simulate_paths(runaway, 11, 1.5, vary={"controller.k": k}) for k in (STIFFNESS, calm)
    )
    stable = np.array(STIFFNESS) >= 0
    assert np.isnan(wild.diverged_at[stable]).all()
    for name in ("q", "v", "u"):
        np.testing.assert_array_equal(wild[name][stable], still[name][stable])


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_a_path_that_diverges_at_the_start(engine):
    vary = {"q0": [[0.0, 0.0], [2e4, 0.0], [0.0, -1e4], [9e3, 0.0]]}
    result = simulate_paths(masses(), 4, 0.01, vary=vary, engine=engine)
    np.testing.assert_array_equal(result.diverged_at, [np.nan, 0.0, 0.0, np.nan])
    assert np.isnan(result.q[1:3]).all()
    assert np.isfinite(result.q[[0, 3]]).all()


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_a_law_that_computes_nan_gives_no_torque_on_its_path_alone(engine):
    class Root(Spring):
        def step(self, state, measured, desired, period):
            q = measured.q
            return {"u": -np.sqrt(self.k + q)}, state

    loop = masses(law=Root(1.0), vibration=None, period=0.1)
    result = simulate_paths(loop, 3, 0.5, vary={"controller.k": [9.0, -1.0, 50.0]}, engine=engine)
    assert result.attrs["engine"] == engine
    assert np.isnan(result.diverged_at).all()
    np.testing.assert_array_equal(result.u[1], 0.0)
    assert (result.u[[0, 2]] != 0.0).all()
    assert np.isfinite(result.q).all()


# Interrupts and memory

LONG_RUN = """
import sys, time
from ftcfa import *
arm = load_arm("double_pendulum")
loop = ClosedLoop(arm, FTCF(arm), Constant(arm.home), substeps={substeps})
simulate_paths(loop, 16, 0.01)
print("running", flush=True)
began = time.process_time()
try:
    simulate_paths(loop, 640, 400.0, record_every=100000, engine="{engine}")
finally:
    print(time.process_time() - began, flush=True)
"""
BEFORE_THE_INTERRUPT = 0.3
"""Time for which the run goes on before it is interrupted [s]."""
AT_ONCE = 5.0
"""Processor time of an interrupted run, at most; the whole run takes more than a minute [s]."""
HANGS = 120.0
"""Time after which a run that ignores the interrupt is killed [s]."""


@pytest.mark.parametrize(
    ("engine", "substeps"), [("compiled", 1), ("compiled", 30_000), ("interpreted", 1)]
)
def test_an_interrupt_ends_a_long_run_at_once(engine, substeps):
    code = LONG_RUN.format(engine=engine, substeps=substeps)
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout.readline().strip() == "running"
            time.sleep(BEFORE_THE_INTERRUPT)
            process.send_signal(2)
            output, errors = process.communicate(timeout=HANGS)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in errors.splitlines()[-1]
    assert float(output) < AT_ONCE
    assert process.returncode != 0


def test_memory_is_the_record_and_little_more(loop):
    simulate_paths(loop, 1, 0.0)
    paths, kept = 20_000, 3
    record = paths * kept * (4 * 2 + 1) * 8  # q, q_d, v, u and ote
    tracemalloc.start()
    try:
        result = simulate_paths(loop, paths, 0.1, record_every=50)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert result.q.shape == (paths, kept, 2)
    # The error q - q_d, its square and the paths' numbers are the rest.
    assert peak < 2.5 * record
