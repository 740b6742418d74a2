"""Robust control of robot arms whose base shakes at random."""

from importlib.metadata import version

from ftcfa.control.filters import ExplicitFilter, ImplicitFilter
from ftcfa.control.ftcf import FTCF, Gains
from ftcfa.control.network import RBFNetwork
from ftcfa.engine.simulate import simulate, simulate_paths
from ftcfa.errors import (
    FtcfaError,
    ParameterError,
    ShapeError,
    TracingError,
    UnknownNameError,
    UrdfError,
)
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.references import Constant, MinimumJerk, Sinusoid, Table
from ftcfa.model.arm import Arm
from ftcfa.model.load import load_arm
from ftcfa.model.pendulum import PaperPendulum
from ftcfa.vibration.excitation import Vibration, WhiteNoise
from ftcfa.vibration.noise_input import BaseAcceleration, PaperPendulumInput

__version__ = version("ftcfa")

__all__ = [
    "FTCF",
    "Arm",
    "BaseAcceleration",
    "ClosedLoop",
    "Constant",
    "ExplicitFilter",
    "FtcfaError",
    "Gains",
    "ImplicitFilter",
    "MinimumJerk",
    "PaperPendulum",
    "PaperPendulumInput",
    "ParameterError",
    "RBFNetwork",
    "ShapeError",
    "Sinusoid",
    "Table",
    "TracingError",
    "UnknownNameError",
    "UrdfError",
    "Vibration",
    "WhiteNoise",
    "load_arm",
    "simulate",
    "simulate_paths",
]
