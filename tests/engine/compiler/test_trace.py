"""What can be traced, what is said of what cannot, and what is kept of what was compiled."""

import contextlib
import gc
import logging
import math
import os
import signal
import threading
import warnings
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from ftcfa import FTCF, ClosedLoop, Gains, Sinusoid, load_arm, simulate, simulate_paths
from ftcfa.engine.compiler import program
from ftcfa.engine.compiler.agreement import AGREEMENT
from ftcfa.engine.compiler.trace import trace
from ftcfa.model.symbols import SymbolArray, symbols

from ..loops import PI, Spring, masses, shaken


class Law:
    """A user's law without memory."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        return {"u": self.torque(q, v)}, state


class Branching(Law):
    def torque(self, q, v):
        if v[0] > 0:  # here
            return -v
        return -2.0 * q


class Comparing(Law):
    def torque(self, q, v):
        return -v * max(q[0], 0.1, key=lambda x: bool(x > 0))  # here


class Mathematical(Law):
    def torque(self, q, v):
        return np.stack([-math.sin(q[0]), -v[1]])  # here


class Filling(Law):
    def torque(self, q, v):
        u = np.zeros(2)
        u[0] = -q[0] - v[0]  # here
        return u


class Formatting(Law):
    def torque(self, q, v):
        return -v - float(f"{q[0]:.3f}")  # here


class Packing(Law):
    def torque(self, q, v):
        return np.array([-q[0], -v[1]])  # here


class Masking(Law):
    def torque(self, q, v):
        return np.where((q > 0) & (v > 0), -q, -v)  # here


class Asserting(Law):
    def torque(self, q, v):
        assert isinstance(q, np.ndarray)  # here
        return -v


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (Branching, "Cannot compute the truth value"),
        (Comparing, "Cannot compute the truth value"),
        (Mathematical, "a symbol has no value; functions of the math module need one"),
        (Filling, "setting an array element"),
        (Formatting, "unsupported format string"),
        (Packing, "a symbol has no value; np.stack makes arrays of symbols"),
        (Masking, "(<ufunc 'bitwise_and'>"),
        (Asserting, "AssertionError"),
    ],
)
def test_a_law_that_cannot_be_traced_runs_interpreted_with_the_line_in_a_warning(law, reason):
    loop = masses(law=law(), period=0.01)
    with pytest.warns(UserWarning, match="running interpreted") as caught:
        result = simulate(loop, 0.1)
    assert len(caught) == 1
    text = str(caught[0].message)
    lines = Path(__file__).read_text().splitlines()
    begin = lines.index(f"class {law.__name__}(Law):")
    line = next(i for i in range(begin, len(lines)) if lines[i].endswith("# here"))
    assert f"{__file__}, line {line + 1}: {lines[line].split('  #')[0].strip()}" in text
    assert reason in text
    assert "use np.where for if, np.stack for np.array" in text
    assert result.attrs["engine"] == "interpreted"
    truth = simulate(loop, 0.1, engine="interpreted")
    np.testing.assert_array_equal(result.u, truth.u)


class PlainLaw(Law):
    """A law that is no dataclass, so that tracing does not find its Arm."""

    def __init__(self, arm):
        self.arm = arm

    def torque(self, q, v):
        return self.arm.potential_force(q) - v


def test_a_law_that_hides_its_arm_runs_interpreted_with_the_remedy_in_a_warning():
    arm = load_arm("double_pendulum")
    loop = shaken(arm, "xz", controller=PlainLaw(arm))
    with pytest.warns(UserWarning, match="running interpreted") as caught:
        assert simulate(loop, 0.01).attrs["engine"] == "interpreted"
    text = str(caught[0].message)
    assert "return self.arm.potential_force(q) - v: cannot be traced" in text
    assert "if PlainLaw holds an Arm, make it a frozen dataclass with the Arm in a field" in text


class HiddenDict(Law):
    """An integrator whose state nobody sees."""

    def __init__(self):
        self.memory = {}

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        error = self.memory.get("error", np.zeros(2)) + period * (q - desired.q)
        self.memory["error"] = error
        return {"u": -v - 9.0 * error}, state


class HiddenUntilInit(HiddenDict):
    """The same, but each path starts anew."""

    def init(self, measured, desired):
        self.memory = {}
        return ()


class Dice(Law):
    def __init__(self):
        self.rng = np.random.default_rng(0)

    def torque(self, q, v):
        return -v - q + self.rng.standard_normal(2)


class TwoFaced(Law):
    """Asks what kind of value it was given."""

    def torque(self, q, v):
        return -v if isinstance(q, np.ndarray) else -2.0 * v


class Guarded(Law):
    """Catches what tracing raises."""

    def torque(self, q, v):
        try:
            factor = 1.0 if q[0] > 0 else 2.0
        except RuntimeError:
            factor = 3.0
        return -factor * v


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (HiddenDict, "the same inputs gave results that differ by"),
        (HiddenUntilInit, "the same inputs gave results that differ by"),
        (Dice, "the same inputs gave results that differ by"),
        (TwoFaced, "traced, it differs from the loop's own by"),
        (Guarded, "traced, it differs from the loop's own by"),
    ],
)
def test_a_law_that_tracing_would_get_wrong_runs_interpreted(law, reason):
    with pytest.warns(UserWarning, match="running interpreted") as caught:
        result = simulate(masses(law=law(), v0=[0.1, 0.2], period=0.01), 0.1)
    assert len(caught) == 1
    text = str(caught[0].message)
    assert f"{__file__}, line " in text
    assert f"{law.__name__}: u: {reason}" in text
    assert result.attrs["engine"] == "interpreted"
    assert np.all(np.isfinite(result.u))


def test_hidden_state_that_init_clears_is_right_interpreted():
    loops = [masses(law=HiddenUntilInit(), period=0.01) for _ in range(2)]
    with pytest.warns(UserWarning, match="running interpreted"):
        result = simulate(loops[0], 0.1)
    np.testing.assert_array_equal(result.u, simulate(loops[1], 0.1, engine="interpreted").u)


class Stateful(Law):
    def __init__(self, start):
        self.start = start

    def init(self, measured, desired):
        return self.start

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        (error,) = state.values() if isinstance(state, dict) else state
        error = error + period * (q - desired.q)
        kind = type(state)
        return {"u": -v - error}, {"error": error} if kind is dict else kind([error])


@pytest.mark.parametrize(
    ("start", "reason"),
    [
        ({"error": np.zeros(2)}, "Stateful: state from init: holds a dict, expected numbers"),
        ([np.zeros(2)], "Stateful: state from init: holds a list, expected numbers"),
        ((0.0,), "state of Stateful: 5 numbers from init, 6 from step"),
    ],
)
def test_a_state_that_code_cannot_hold_is_interpreted(start, reason):
    loop = masses(law=Stateful(start), period=0.01)
    with pytest.warns(UserWarning, match="running interpreted") as caught:
        result = simulate(loop, 0.1)
    assert len(caught) == 1
    assert reason in str(caught[0].message)
    fine = simulate(masses(law=Stateful((np.zeros(2),)), period=0.01), 0.1)
    assert fine.attrs["engine"] == "compiled"
    np.testing.assert_allclose(result.u, fine.u, rtol=1e-12)


class NoState(Spring):
    def init(self, measured, desired):
        return None


class SelfReference(Spring):
    def __init__(self):
        super().__init__(2.0, 1.0)
        object.__setattr__(self, "me", self)
        object.__setattr__(self, "log", logging.getLogger("law"))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("law", [NoState(2.0, 1.0), SelfReference()])
def test_unusual_laws_are_compiled(law):
    assert simulate(masses(law=law), 0.01).attrs["engine"] == "compiled"


@dataclass(frozen=True)
class ComputedTorque:
    """A user's law on everything that an Arm offers, its robots in a tuple."""

    robots: tuple

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        arm = self.robots[0]
        a = desired.a - 20.0 * (v - desired.v) - 100.0 * (q - desired.q)
        u = arm.mass_matrix(q) @ a + arm.coriolis_matrix(q, v) @ v + arm.potential_force(q)
        u = u + arm.friction_force(v) + 0.0 * arm.damping_matrix(v) @ v
        margin = np.minimum(arm.upper - q, q - arm.lower) / arm.velocity_limit
        return {"u": u, "margin": margin, "a": arm.forward_dynamics(q, v, u)}, state


@pytest.mark.filterwarnings("error")
def test_the_twin_answers_all_that_the_arm_does():
    arm = load_arm("xarm7")
    loop = shaken(arm, controller=ComputedTorque((arm,)))
    compiled, interpreted = (
        simulate(loop, 0.05, signals="all", engine=engine) for engine in ("compiled", "interpreted")
    )
    assert compiled.attrs["engine"] == "compiled"
    for name in ("q", "v", "u", "margin", "a"):
        scale = np.abs(interpreted[name]).max()
        assert np.abs(compiled[name] - interpreted[name]).max() <= 1e-11 * scale, name


def test_symbols_have_no_value():
    x = symbols("x", 3)
    assert x.shape == (3,)
    for convert in (float, int, math.sin, lambda one: f"{one:.3f}", bool):
        with pytest.raises((TypeError, RuntimeError)):
            convert(x[0])
    y = x
    y += 1.0  # makes another array
    assert y is not x
    assert float((x - x)[0] + 2.0) == 2.0


def test_another_user_of_casadi_sees_nothing_of_tracing():
    """CasADi's own symbols convert to NaN in another thread, while a law is being traced."""

    class Waiting(Law):
        def torque(self, q, v):
            if isinstance(q, SymbolArray):
                tracing.set()
                assert looked.wait(60)
            return -v - q

    def look():
        assert tracing.wait(60)
        try:
            return [float(ca.ArrayInterface(ca.SX.sym("x"), ndim=0)) for _ in range(100)]
        finally:
            looked.set()

    tracing, looked = threading.Event(), threading.Event()
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(look)
        result = simulate(masses(law=Waiting()), 0.0)
        assert np.all(np.isnan(other.result()))
    assert result.attrs["engine"] == "compiled"


def test_a_bug_in_a_law_is_the_users_error():
    class Buggy(Law):
        def torque(self, q, v):
            return undefined_name * q * v  # noqa: F821

    for engine in ("compiled", "interpreted"):
        with pytest.raises(NameError, match="undefined_name"):
            simulate(masses(law=Buggy()), 0.01, engine=engine)


# What is kept


@pytest.fixture
def compilations(monkeypatch):
    """Counts what is compiled."""
    texts, truly = [], program.machine_code

    def counted(text, *rest):
        texts.extend([text] * ("@run(" in text))
        return truly(text, *rest)

    monkeypatch.setattr(program, "machine_code", counted)
    monkeypatch.setattr(program, "_cache", type(program._cache)())
    return texts


def pendulum(c1=7.5, **changes):
    arm = load_arm("double_pendulum")
    return shaken(arm, "xz", controller=FTCF(arm, Gains(c1=c1)), **changes)


def test_a_loop_is_compiled_once(compilations):
    loop = pendulum()
    for seed, path, duration, every in [(0, 0, 0.01, 1), (1, 0, 0.02, 3), (0, 5, 0.0, 2)]:
        simulate(loop, duration, seed=seed, path=path, record_every=every)
    simulate_paths(loop, 20, 0.01, threads=2)
    assert len(compilations) == 1


def test_an_equal_loop_is_not_compiled_again(compilations):
    for _ in range(3):
        simulate(pendulum(), 0.01)
    assert len(compilations) == 1


def test_start_and_reference_are_no_part_of_the_code_that_steps(compilations):
    simulate(pendulum(), 0.01)
    simulate(pendulum(reference=Sinusoid([0.1, 0.2])), 0.01)
    assert len(compilations) == 1


def test_values_that_vary_are_not_compiled_in(compilations):
    rng = np.random.default_rng(0)
    loop = pendulum()
    for _ in range(3):
        vary = {
            "controller.gains.c1": rng.uniform(5, 9, 4),
            "arm.inertias": np.array([loop.arm.perturbed(rng).inertias for _ in range(4)]),
            "process.sigma": rng.standard_normal((4, 2, 2)),
        }
        simulate_paths(loop, 4, 0.01, vary=vary)
    assert len(compilations) == 1


def test_other_constants_are_other_programs(compilations):
    results = [simulate(pendulum(c1), 0.5).q[-1].values for c1 in (7.5, 7.4, 7.5)]
    assert len(compilations) == 2
    np.testing.assert_array_equal(results[0], results[2])
    assert np.any(results[0] != results[1])


def test_few_programs_of_loops_that_are_gone_are_kept(compilations, monkeypatch):
    monkeypatch.setattr(program, "CACHED_PROGRAMS", 2)

    def run(k):
        return simulate(masses(law=Spring(float(k))), 0.01).v.values

    before = [run(k) for k in range(3)]
    assert len(program._cache) == 2
    assert len(compilations) == 3
    np.testing.assert_array_equal(run(2), before[2])  # the same program for another such loop
    assert len(compilations) == 3
    np.testing.assert_array_equal(run(0), before[0])  # dropped, and compiled again
    assert len(compilations) == 4


def test_a_loop_keeps_its_program(compilations, monkeypatch):
    monkeypatch.setattr(program, "CACHED_PROGRAMS", 1)
    loops = [masses(law=Spring(float(k))) for k in range(3)]
    for loop in 2 * loops:
        simulate(loop, 0.01)
    assert len(compilations) == 3


def test_a_law_whose_gains_were_changed_is_traced_anew():
    @dataclass
    class Mutable:
        k: float

        def init(self, measured, desired):
            return ()

        def step(self, state, measured, desired, period):
            q, v = measured.q, measured.v
            return {"u": -self.k * q - v}, state

    loop = masses(law=Mutable(1.0), q0=[0.3, -0.2], period=0.01)
    for k in (1.0, 5.0, 2.0):
        loop.controller.k = k
        result = simulate(loop, 0.1)
        assert result.attrs["engine"] == "compiled"
        expected = -k * result.q - result.v
        np.testing.assert_allclose(result.u, expected, rtol=10 * AGREEMENT)


def test_nothing_keeps_a_loop_or_an_arm_in_memory():
    loop = pendulum()
    simulate_paths(loop, 3, 0.01, vary={"arm.inertias": np.array([loop.arm.inertias] * 3)})
    law = masses(law=Branching())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        simulate(law, 0.01)
    plain = masses(law=Spring(1.0))
    simulate_paths(plain, 2, 0.01, vary={"q0": np.ones((2, 2)), "controller.k": [1.0, 2.0]})
    loops = (loop, loop.arm, loop.controller, law, law.arm, plain, plain.arm)
    references = [weakref.ref(x) for x in loops]
    del loop, law, plain, loops
    gc.collect()
    assert [ref() for ref in references] == [None] * len(references)


def test_tracing_gives_the_requested_signals():
    loop = ClosedLoop(load_arm("double_pendulum"), PI(), Sinusoid([0.1, 0.2]), substeps=2)
    traced = trace(loop, ["corner", "energy", "q"])
    assert traced.signals == (("corner", (2, 2)), ("energy", ()), ("q", (2,)))
    assert (traced.recorded, traced.driven, traced.substeps) == (7, 2, 2)
    assert trace(loop, ["corner", "energy", "q"]) is traced
    assert trace(loop, ["q"]) is not traced


class Interrupted(Law):
    """A spring that, when it is traced, swallows Ctrl-C as CasADi can."""

    def torque(self, q, v):
        if isinstance(q, SymbolArray):
            with contextlib.suppress(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGINT)
        return -q


def test_ctrl_c_during_tracing_is_obeyed():
    loop = ClosedLoop(load_arm("double_pendulum"), Interrupted(), Sinusoid([0.3, 0.2]))
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        simulate(loop, 0.01)
    assert signal.getsignal(signal.SIGINT) is before
