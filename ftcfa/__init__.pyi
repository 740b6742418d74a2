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
from .vibration.excitation import WhiteNoise
from .vibration.fitting import FilterFit, fit_filter
from .vibration.noise_input import BaseAcceleration, NoiseInput, PaperPendulumInput
from .vibration.record import Record
from .vibration.record_file import read_record
from .vibration.recorded import RecordedAcceleration
from .vibration.shaped_noise import ShapedNoise
from .vibration.shaping import LinearFilter
from .vibration.spectrum import Spectrum
from .vibration.standards import Standard, read_table, standard, standards
from .vibration.vibration import Vibration

__version__: str

__all__ = [
    "FTCF",
    "Arm",
    "BaseAcceleration",
    "ClosedLoop",
    "Constant",
    "ExplicitFilter",
    "FilterFit",
    "FtcfaError",
    "Gains",
    "ImplicitFilter",
    "LinearFilter",
    "MinimumJerk",
    "NoiseInput",
    "PaperPendulum",
    "PaperPendulumInput",
    "ParameterError",
    "RBFNetwork",
    "Record",
    "RecordedAcceleration",
    "ShapeError",
    "ShapedNoise",
    "Sinusoid",
    "Spectrum",
    "Standard",
    "Table",
    "TracingError",
    "UnknownNameError",
    "UrdfError",
    "Vibration",
    "WhiteNoise",
    "__version__",
    "fit_filter",
    "load_arm",
    "read_record",
    "read_table",
    "simulate",
    "simulate_paths",
    "standard",
    "standards",
]
