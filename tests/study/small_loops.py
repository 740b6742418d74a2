"""Closed loops that take a moment: the paper's pendulum, certain and not, and a user's own."""

from dataclasses import replace
from functools import cache

import numpy as np
import xarray as xr

from ftcfa import ClosedLoop, Sinusoid, Uncertainty, Vibration, WhiteNoise
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

DURATION = 0.1
"""A hundred samples [s]."""


@cache  # compiled once for all tests of a process
def pendulum(moved=0.0):
    loop = closed_loop(FINITE_TIME)
    return replace(loop, q0=loop.q0 + moved)


@cache
def uncertain_pendulum():
    return replace(pendulum(), uncertainty=Uncertainty(mass=0.2, centre=0.01, shape=0.1))


class Masses:
    """A user's plant: unit masses."""

    def __init__(self, n):
        self.n = n
        self.joint_names = tuple(f"mass{k}" for k in range(n))
        self.joint_types = ("prismatic",) * n
        self.effort_limit = np.full(n, 1e9)
        self.home = np.zeros(n)

    def mass_matrix(self, q):
        return np.eye(self.n)

    def damping_matrix(self, v):
        return np.zeros((self.n, self.n))

    def bias_force(self, q, v):
        return np.zeros_like(q)


class Push:
    """A user's noise input: a channel for each mass."""

    def __init__(self, n):
        self.channels = n

    def matrix(self, arm, q):
        return np.eye(self.channels)


class Spring:
    """A user's law, and one whose numbers no description tells: u = -k q - d v."""

    def __init__(self, k, d):
        self.k, self.d = k, d

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        return {"u": -self.k * q - self.d * v}, state


def oscillators(n, k, d, period=1e-2, **changes):
    """n independent x'' = -k x - d x' + xi from rest, xi white of intensity one."""
    vibration = Vibration(Push(n), WhiteNoise(1.0))
    rest = Sinusoid(np.zeros(n))
    return ClosedLoop(Masses(n), Spring(k, d), rest, vibration, period=period, **changes)


def read_all(store):
    """Every group of a store, by xarray and zarr alone; raises if one cannot be read."""
    import zarr

    zarr.open_group(store, mode="r").attrs["identity"]
    groups = ["result"] if (store / "result").exists() else []
    groups += [f"chunks/{it.name}" for it in (store / "chunks").iterdir() if it.name.isdecimal()]
    return {group: xr.open_zarr(store, group=group, consolidated=False).load() for group in groups}
