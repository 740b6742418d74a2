"""Free unit masses pushed by an excitation: their velocities are its integral."""

import numpy as np

from ftcfa import ClosedLoop, Sinusoid, Vibration, simulate

AGREEMENT = 1e-9
"""Of the engines: rounding of another order of operations."""
CONFIDENCE = 1 - 1e-6


class Mass:
    """A user's plant: one free unit mass a channel."""

    def __init__(self, n=1):
        self.n = n
        self.joint_names = tuple(f"slider{k}" for k in range(n))
        self.joint_types = ("prismatic",) * n
        self.effort_limit = np.ones(n)
        self.home = np.zeros(n)

    def mass_matrix(self, q):
        return np.eye(self.n)

    def damping_matrix(self, v):
        return np.zeros((self.n, self.n))

    def bias_force(self, q, v):
        return np.zeros_like(q)


class Push:
    """A user's noise input: straight onto the masses."""

    def __init__(self, channels=1):
        self.channels = channels

    def matrix(self, arm, q):
        return np.eye(self.channels)


class Rest:
    """A law that does nothing."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
        return {"u": np.zeros_like(q)}, state


def pushed(excitation, n=1, **changes):
    vibration = Vibration(Push(n), excitation)
    return ClosedLoop(Mass(n), Rest(), Sinusoid(np.zeros(n)), vibration, **changes)


def check_engines(loop, duration=0.2, names=("q", "v", "u")):
    """Both engines give the same path."""
    runs = [simulate(loop, duration, seed=3, path=5, engine=e) for e in ("compiled", "interpreted")]
    assert runs[0].attrs["engine"] == "compiled"
    for name in names:
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=AGREEMENT, atol=AGREEMENT)


def run_process(process, steps, normals=None, initial=None, first=0):
    """Y, W and U of a process by its own functions, shapes (steps, m) and twice one more."""
    state = process.init(np.zeros(process.initial_normals) if initial is None else initial)
    normals = np.zeros((steps, process.normals)) if normals is None else normals
    Y, both = [], []
    for k in range(steps + 1):
        row = process.rows[(first + k) % len(process.rows)]
        both.append(process.integrals(state, row))
        if k < steps:
            integral, state = process.advance(state, normals[k], row)
            Y.append(integral)
    W, U = (np.array(values) for values in zip(*both, strict=True))
    return np.array(Y), W, U
