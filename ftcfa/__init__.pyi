from .control.command_filtered import CommandFilteredBackstepping
from .control.computed_torque import ComputedTorque
from .control.feed_forward import FeedForward, Predictor
from .control.filters import ExplicitFilter, ImplicitFilter, ProperFilter, SecondOrderFilter
from .control.finite_time_backstepping import FiniteTimeBackstepping
from .control.ftcf import FTCF
from .control.gains import Gains
from .control.laws import ABLATIONS, CONTROLLERS, ablated, printed
from .control.network import RBFNetwork
from .control.pd_gravity import PDGravity
from .control.position_feedback import PositionFeedback
from .control.slotine_li import SlotineLi
from .control.stochastic_backstepping import StochasticBackstepping
from .control.super_twisting import SuperTwisting
from .control.tuned import tuned_gains, tuned_law
from .engine.simulate import simulate, simulate_paths
from .errors import (
    ExperimentError,
    FtcfaError,
    ParameterError,
    ShapeError,
    TracingError,
    UnknownNameError,
    UrdfError,
)
from .experiment import Experiment, load_experiment
from .hardware.accelerometer import Accelerometer, Gyroscope
from .hardware.actuators import Actuators
from .hardware.hardware import Hardware
from .hardware.profiles import (
    Profile,
    accelerometer_profile,
    accelerometers,
    hardware_profile,
    profiles,
)
from .hardware.sensors import Sensors
from .hardware.velocity import BackwardDifference, Kalman, Levant, ModelObserver
from .loop.base_predictor import base_predictor
from .loop.closed_loop import ClosedLoop
from .loop.feed_forward import FeedForwardBand, feed_forward_band, with_feed_forward
from .loop.references import Constant, MinimumJerk, Sinusoid, Table
from .loop.suggested_gains import suggest_gains
from .model.arm import Arm
from .model.pendulum import PaperPendulum
from .model.uncertainty import Uncertainty
from .model.urdf.load import load_arm
from .parts import number_fields
from .study.comparison import compare
from .study.ensemble import ensemble
from .study.progress import Interrupted
from .study.realised_spectrum import (
    RealisedStandard,
    SpectrumEstimate,
    estimate_spectrum,
    realise_standard,
)
from .study.summary import replay, settled_in_mean_square, settling
from .study.tuning.front import front
from .study.tuning.objective import Limit, Objective, Term
from .study.tuning.result import Tuning
from .study.tuning.sensitivity import sensitivity
from .study.tuning.space import joint_by_joint, search_space
from .study.tuning.tune import tune
from .study.variants import ablations, conditions, rivals
from .study.verification import Specification, Verification, verify
from .theory.bounds import bounds
from .theory.gain_conditions import gain_shortfall
from .theory.inertia_split import InertiaBounds, InertiaSplit, inertia_bounds, inertia_split
from .theory.theorem1 import Bounds
from .vibration.excitation import Stacked, Superposition
from .vibration.excitations.harmonic import Harmonic
from .vibration.excitations.random_phase import RandomPhase
from .vibration.excitations.recorded import RecordedAcceleration
from .vibration.excitations.shaped_noise import ShapedNoise
from .vibration.excitations.sweep import SineSweep
from .vibration.excitations.white_noise import WhiteNoise
from .vibration.inputs.base_motion import BaseMotion
from .vibration.inputs.noise_input import (
    BaseAcceleration,
    FrameWrench,
    JointTorque,
    NoiseInput,
    PaperPendulumInput,
)
from .vibration.realisation import realise
from .vibration.records.record import Record, read_record
from .vibration.spectra.filter_fit import FilterFit, fit_filter
from .vibration.spectra.linear_filter import LinearFilter
from .vibration.spectra.road import PASSENGER_CAR, TRUCK, QuarterCar, Road
from .vibration.spectra.spectrum import Spectrum
from .vibration.spectra.standards import Standard, read_table, standard, standards
from .vibration.vibration import Vibration

__version__: str

__all__ = [
    "ABLATIONS",
    "CONTROLLERS",
    "FTCF",
    "PASSENGER_CAR",
    "TRUCK",
    "Accelerometer",
    "Actuators",
    "Arm",
    "BackwardDifference",
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
    "FeedForward",
    "FeedForwardBand",
    "FilterFit",
    "FiniteTimeBackstepping",
    "FrameWrench",
    "FtcfaError",
    "Gains",
    "Gyroscope",
    "Hardware",
    "Harmonic",
    "ImplicitFilter",
    "InertiaBounds",
    "InertiaSplit",
    "Interrupted",
    "JointTorque",
    "Kalman",
    "Levant",
    "Limit",
    "LinearFilter",
    "MinimumJerk",
    "ModelObserver",
    "NoiseInput",
    "Objective",
    "PDGravity",
    "PaperPendulum",
    "PaperPendulumInput",
    "ParameterError",
    "PositionFeedback",
    "Predictor",
    "Profile",
    "ProperFilter",
    "QuarterCar",
    "RBFNetwork",
    "RandomPhase",
    "RealisedStandard",
    "Record",
    "RecordedAcceleration",
    "Road",
    "SecondOrderFilter",
    "Sensors",
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
    "Term",
    "TracingError",
    "Tuning",
    "Uncertainty",
    "UnknownNameError",
    "UrdfError",
    "Verification",
    "Vibration",
    "WhiteNoise",
    "__version__",
    "ablated",
    "ablations",
    "accelerometer_profile",
    "accelerometers",
    "base_predictor",
    "bounds",
    "compare",
    "conditions",
    "ensemble",
    "estimate_spectrum",
    "feed_forward_band",
    "fit_filter",
    "front",
    "gain_shortfall",
    "hardware_profile",
    "inertia_bounds",
    "inertia_split",
    "joint_by_joint",
    "load_arm",
    "load_experiment",
    "number_fields",
    "printed",
    "profiles",
    "read_record",
    "read_table",
    "realise",
    "realise_standard",
    "replay",
    "rivals",
    "search_space",
    "sensitivity",
    "settled_in_mean_square",
    "settling",
    "simulate",
    "simulate_paths",
    "standard",
    "standards",
    "suggest_gains",
    "tune",
    "tuned_gains",
    "tuned_law",
    "verify",
    "with_feed_forward",
]
