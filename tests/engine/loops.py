"""Closed loops for the tests of the engines: arms, laws and plants of a user's own."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    number_fields,
)
from ftcfa.model.urdf.catalogue import catalogue

FULL_VARPI = [[0.2, 0.1, 0.0], [0.1, 0.3, 0.05], [0.0, 0.05, 0.1]]

GANTRY = """<robot name="gantry"><link name="rail"/>
<link name="trolley"><inertial><origin xyz="0 0.1 0"/><mass value="5"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="rod"><inertial><origin xyz="0.02 0 -0.4"/><mass value="1.5"/>
  <inertia ixx="0.08" ixy="0.001" ixz="0" iyy="0.09" iyz="0" izz="0.03"/></inertial></link>
<link name="hook"><inertial><origin xyz="0 0 -0.1"/><mass value="0.7"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="trolley"/>
  <axis xyz="1 0.2 0"/><limit lower="-3" upper="3" effort="80" velocity="2"/>
  <dynamics damping="1.5" friction="0.5"/></joint>
<joint name="swing" type="revolute"><parent link="trolley"/><child link="rod"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="40" velocity="4"/></joint>
<joint name="hoist" type="prismatic"><parent link="rod"/><child link="hook"/>
  <origin xyz="0 0 -0.8" rpy="0.1 0 0.3"/><axis xyz="0 0 -1"/>
  <limit lower="-1" upper="1" effort="60" velocity="2"/></joint>
</robot>"""


def gantry(folder):
    """A trolley on a rail, a rod that swings below it and a hook that slides along the rod."""
    file = folder / "gantry.urdf"
    file.write_text(GANTRY)
    return load_arm(str(file))


def panda_with_gripper():
    """Eight coordinates: one finger mimics the other."""
    return load_arm(str(catalogue()["panda"].path()))


def shaken(arm, axes="xyz", intensity=0.1, convention="psd", **changes):
    """The paper's controller about home, the base shaken by white noise."""
    vibration = Vibration(BaseAcceleration(axes), WhiteNoise(intensity, convention))
    parts = {
        "controller": FTCF(arm),
        "reference": Sinusoid(0.3, 1.0, 0.0, arm.home),
        "vibration": vibration,
    }
    return ClosedLoop(arm, **{**parts, **changes})


class Nothing(NamedTuple):
    """The state of a law without memory."""


@dataclass(frozen=True)
class Spring:
    """u = -k (q - q_d) - d v."""

    k: float = 0.0
    d: float = 0.0
    varies = number_fields("k", "d")

    def init(self, measured, desired):
        return Nothing()

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        return {"u": -self.k * (q - desired.q) - self.d * v}, state


class Integral(NamedTuple):
    """The state of a PI law."""

    error: np.ndarray
    ticks: int


@dataclass(frozen=True)
class PI:
    """u = -p v - i integral of (q - q_d), with signals of all shapes."""

    p: float = 5.0
    i: float = 20.0
    varies = number_fields("p", "i")

    def init(self, measured, desired):
        q = measured.q
        return Integral(np.zeros_like(q), 0)

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        error = state.error + period * (q - desired.q)
        signals = {
            "u": -self.p * v - self.i * error,
            "energy": v @ v,
            "corner": np.stack([q, v, error])[:2],
            "fast": np.abs(v) > 0.1,
            "count": state.ticks,
            "gain": np.array([self.p, self.i]),
        }
        return signals, Integral(error, state.ticks + 1)


@dataclass(frozen=True, eq=False)
class Masses:
    """A user's plant: n unit masses that nothing pulls at."""

    n: int = 2
    joint_types: tuple = ("prismatic",) * 2
    force: float = 1e9

    @property
    def joint_names(self):
        return tuple(f"mass{i}" for i in range(self.n))

    @property
    def effort_limit(self):
        return np.full(self.n, self.force)

    @property
    def home(self):
        return np.zeros(self.n)

    def mass_matrix(self, q):
        return np.eye(self.n)

    def potential_force(self, q):
        return np.zeros_like(q)

    def damping_matrix(self, v):
        return np.zeros((self.n, self.n))

    def bias_force(self, q, v):
        return np.zeros_like(q)

    def base_coupling(self, q):
        return np.zeros((self.n, 6))


@dataclass(frozen=True)
class Force:
    """A user's noise input: one channel a joint, straight onto it."""

    channels: int = 2

    def matrix(self, arm, q):
        return np.eye(self.channels)


def masses(n=2, law=None, **changes):
    """Unit masses, each pushed by its own noise of intensity one, under a law that does nothing."""
    arm = Masses(n, ("prismatic",) * n)
    vibration = Vibration(Force(n), WhiteNoise(1.0))
    parts = {"controller": law or Spring(), "reference": Sinusoid(np.zeros(n))}
    return ClosedLoop(arm, **{**parts, "vibration": vibration, **changes})
