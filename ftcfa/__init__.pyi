from .control.filters import ExplicitFilter, ImplicitFilter
from .control.ftcf import FTCF, Gains
from .control.network import RBFNetwork
from .engine.simulate import simulate, simulate_paths
from .errors import (
    FtcfaError,
    ParameterError,
    ShapeError,
    TracingError,
    UnknownNameError,
    UrdfError,
)
from .loop.closed_loop import ClosedLoop
from .loop.references import Constant, MinimumJerk, Sinusoid, Table
from .model.arm import Arm
from .model.load import load_arm
from .model.pendulum import PaperPendulum
from .vibration.excitation import Vibration, WhiteNoise
from .vibration.noise_input import BaseAcceleration, PaperPendulumInput

__version__: str

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
    "__version__",
    "load_arm",
    "simulate",
    "simulate_paths",
]
