"""Properties of every law in a loop, on six arms and both engines."""

import warnings

import numpy as np
import pytest

from ftcfa import (
    CONTROLLERS,
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
)
from ftcfa.control.filters import FILTERS
from ftcfa.control.protocol import Desired, MemorylessLaw, quantities
from ftcfa.engine.compiler.agreement import check_pure
from ftcfa.engine.compiler.flatten import leaves
from ftcfa.loop.command import LOOP_QUANTITIES
from ftcfa.loop.state import LoopState, Motion

from .arms import ARMS, arm_of

pytestmark = pytest.mark.filterwarnings("error")  # no silent fall back to interpreting

DURATION = 0.02
AGREEMENT = 1e-8
"""Between the engines, relative to the largest value of a signal and at least to 1: rounding,
magnified by the slope of the laws' roots and by light links."""
OFFSET = 0.05
"""Where the arms start beside their reference [rad or m]."""
NUMBERS = (0.0, -0.0, 1e-300, 1.0, -1e3, 1e300, np.inf, -np.inf, np.nan)
"""Numbers that sensors may give."""

LAWS = {
    **CONTROLLERS,
    **{f"FTCF, {name} filter": lambda arm, name=name: FTCF(arm, filter=name) for name in FILTERS},
}


@pytest.fixture(scope="module", params=ARMS)
def arm(request, tmp_path_factory):
    return arm_of(request.param, tmp_path_factory.mktemp("arm"))


@pytest.fixture(params=LAWS)
def loop(arm, request):
    return ClosedLoop(
        arm,
        LAWS[request.param](arm),
        Sinusoid(0.3, 1.0, 0.0, arm.home),
        Vibration(BaseAcceleration(), WhiteNoise(0.1)),
        q0=arm.home + OFFSET,
    )


def first(loop):
    return Desired(*(row[0] for row in loop.reference.at(np.zeros(1))))


def test_both_engines_run_it_alike_within_the_limits(loop):
    """Compiled without a warning: pure, traceable, and the same numbers again."""
    paths = [
        simulate(loop, DURATION, seed=1, path=2, signals="all", engine=engine)
        for engine in ("compiled", "compiled", "interpreted")
    ]
    ours, again, theirs = paths
    assert np.isnan(ours.diverged_at)
    for name in theirs.data_vars:
        a, b = np.asarray(ours[name], dtype=float), np.asarray(theirs[name], dtype=float)
        np.testing.assert_array_equal(a, again[name], err_msg=name)
        if name != "diverged_at":
            assert np.all(np.isfinite(a)), name
            scale = max(1.0, np.max(np.abs(b)))
            np.testing.assert_allclose(a, b, rtol=0, atol=AGREEMENT * scale, err_msg=name)
    assert np.all(np.abs(ours.u) <= loop.arm.effort_limit)
    assert np.any(ours.u != 0)


def test_every_signal_has_a_unit_and_a_meaning(loop):
    signals, *_ = loop.control(loop.init(first(loop)), first(loop))
    assert set(quantities(loop.controller)) == set(signals) - set(LOOP_QUANTITIES)
    assert all(unit and meaning for unit, meaning in loop.quantities.values())
    run = simulate(loop, DURATION, signals="all", engine="interpreted")
    assert all(run[name].units and run[name].long_name for name in signals)
    if "prismatic" in loop.arm.joint_types:
        assert all("prismatic joints" in run[k].units for k in signals if "joint" in run[k].dims)


class Spring(MemorylessLaw):
    """A user's law that lists no quantities."""

    def signals(self, measured, desired):
        q = measured.q
        return {"u": desired.q - q, "stretch": q - desired.q}


def test_a_signal_that_its_law_does_not_list_has_its_name_and_no_unit():
    arm = load_arm("double_pendulum")
    loop = ClosedLoop(arm, Spring(arm), Sinusoid(offset=arm.home))
    run = simulate(loop, DURATION, signals="all")
    assert (run.stretch.units, run.stretch.long_name) == ("", "stretch")
    assert run.u_command.units == "N m"


def test_its_state_keeps_its_shape_and_hides_nothing(loop):
    check_pure(loop)
    state = loop.init(first(loop))
    _, _, after = loop.control(state, first(loop))
    assert [np.shape(x) for x in leaves(after)] == [np.shape(x) for x in leaves(state)]
    assert type(after.controller) is type(state.controller)


def test_no_measurement_gets_a_torque_beyond_the_limits_or_none_at_all(loop):
    """Numbers, infinities and NaN in q and v, sample after sample."""
    rng, n = np.random.default_rng(0), loop.arm.n
    desired, limit = first(loop), loop.arm.effort_limit
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        state = loop.init(desired)
        for _ in range(8):
            q, v = rng.choice(NUMBERS, size=(2, n))
            state = LoopState(Motion(q, v, state.motion.vibration), state.controller)
            signals, _, state = loop.control(state, desired)
            assert np.all(np.abs(signals["u"]) <= limit)  # false for NaN
            assert all(np.all(np.isfinite(leaf)) for leaf in leaves(state.controller))


def test_after_a_measurement_of_nan_the_law_works_on(loop):
    """The law keeps nothing of a NaN: the next sample gives a finite torque."""
    desired, state = first(loop), loop.init(first(loop))
    broken = LoopState(state.motion._replace(q=np.full(loop.arm.n, np.nan)), state.controller)
    signals, _, after = loop.control(broken, desired)
    np.testing.assert_array_equal(signals["u"], 0.0)
    signals, *_ = loop.control(LoopState(state.motion, after.controller), desired)
    assert np.all(np.isfinite(signals["u_command"]))
