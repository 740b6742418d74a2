from .control.command_filtered import CommandFilteredBackstepping
from .control.computed_torque import ComputedTorque
from .control.filters import ExplicitFilter, ImplicitFilter, ProperFilter, SecondOrderFilter
from .control.finite_time_backstepping import FiniteTimeBackstepping
from .control.ftcf import FTCF, Gains
from .control.network import RBFNetwork
from .control.pd_gravity import PDGravity
from .control.rivals import ABLATIONS, CONTROLLERS, ablated
from .control.slotine_li import SlotineLi
from .control.stochastic_backstepping import StochasticBackstepping
from .control.super_twisting import SuperTwisting
from .engine.simulate import simulate, simulate_paths
from .errors import (
    FtcfaError,
    ParameterError,
    ShapeError,
    TracingError,
    UnknownNameError,
    UrdfError,
)
from .experiment import Experiment, load_experiment
from .loop.closed_loop import ClosedLoop
from .loop.faults import ExperimentError
from .loop.references import Constant, MinimumJerk, Sinusoid, Table
from .model.arm import Arm
from .model.load import load_arm
from .model.pendulum import PaperPendulum
from .model.split import InertiaBounds, InertiaSplit, inertia_bounds, inertia_split
from .model.uncertainty import Uncertainty
from .study.bounds import Bounds, bounds
from .study.comparison import compare
from .study.ensemble import ensemble
from .study.summary import replay, settled_in_mean_square, settling
from .study.variants import ablations, conditions, rivals
from .study.verification import Specification, Verification, verify
from .vibration.base_motion import BaseMotion
from .vibration.excitation import WhiteNoise
from .vibration.fitting import FilterFit, fit_filter
from .vibration.noise_input import (
    BaseAcceleration,
    FrameWrench,
    JointTorque,
    NoiseInput,
    PaperPendulumInput,
)
from .vibration.realisation import realise
from .vibration.realised_spectrum import (
    RealisedSpecification,
    SpectrumEstimate,
    estimate_spectrum,
    realise_specification,
)
from .vibration.record import Record
from .vibration.record_file import read_record
from .vibration.recorded import RecordedAcceleration
from .vibration.road import PASSENGER_CAR, TRUCK, QuarterCar, Road
from .vibration.shaped_noise import ShapedNoise
from .vibration.shaping import LinearFilter
from .vibration.spectrum import Spectrum
from .vibration.standards import Standard, read_table, standard, standards
from .vibration.superposition import Stacked, Superposition
from .vibration.sweep import SineSweep
from .vibration.tones import Harmonic, RandomPhase
from .vibration.vibration import Vibration

__version__: str

__all__ = [
    "ABLATIONS",
    "CONTROLLERS",
    "FTCF",
    "PASSENGER_CAR",
    "TRUCK",
    "Arm",
    "BaseAcceleration",
    "BaseMotion",
    "Bounds",
    "ClosedLoop",
    "CommandFilteredBackstepping",
    "ComputedTorque",
    "Constant",
    "Experiment",
    "ExperimentError",
    "ExplicitFilter",
    "FilterFit",
    "FiniteTimeBackstepping",
    "FrameWrench",
    "FtcfaError",
    "Gains",
    "Harmonic",
    "ImplicitFilter",
    "InertiaBounds",
    "InertiaSplit",
    "JointTorque",
    "LinearFilter",
    "MinimumJerk",
    "NoiseInput",
    "PDGravity",
    "PaperPendulum",
    "PaperPendulumInput",
    "ParameterError",
    "ProperFilter",
    "QuarterCar",
    "RBFNetwork",
    "RandomPhase",
    "RealisedSpecification",
    "Record",
    "RecordedAcceleration",
    "Road",
    "SecondOrderFilter",
    "ShapeError",
    "ShapedNoise",
    "SineSweep",
    "Sinusoid",
    "SlotineLi",
    "Specification",
    "Spectrum",
    "SpectrumEstimate",
    "Stacked",
    "Standard",
    "StochasticBackstepping",
    "SuperTwisting",
    "Superposition",
    "Table",
    "TracingError",
    "Uncertainty",
    "UnknownNameError",
    "UrdfError",
    "Verification",
    "Vibration",
    "WhiteNoise",
    "__version__",
    "ablated",
    "ablations",
    "bounds",
    "compare",
    "conditions",
    "ensemble",
    "estimate_spectrum",
    "fit_filter",
    "inertia_bounds",
    "inertia_split",
    "load_arm",
    "load_experiment",
    "read_record",
    "read_table",
    "realise",
    "realise_specification",
    "replay",
    "rivals",
    "settled_in_mean_square",
    "settling",
    "simulate",
    "simulate_paths",
    "standard",
    "standards",
    "verify",
]
