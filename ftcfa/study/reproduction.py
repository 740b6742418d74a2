"""The paper's study (Section V) as data: its cases, and how one runs."""

from dataclasses import dataclass
from typing import Literal

import xarray as xr

from ftcfa.control.ftcf import FTCF
from ftcfa.control.gains import Gains
from ftcfa.control.laws import printed
from ftcfa.engine.simulate import simulate
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.references import Sinusoid
from ftcfa.model.pendulum import PaperPendulum
from ftcfa.model.urdf.load import load_arm
from ftcfa.vibration.excitations.white_noise import Convention, WhiteNoise
from ftcfa.vibration.inputs.noise_input import BaseAcceleration, PaperPendulumInput
from ftcfa.vibration.vibration import Vibration

DURATION = 20.0
"""Simulated time of the paper's figures [s]."""
QUICK_DURATION = 5.0
"""Simulated time of a quick look [s]."""
SEED = 0
"""Seed of the paths."""
BAND = 0.05
"""A path has settled once its overall tracking error stays below this [rad]."""
GRAVITY = 9.8
"""Gravity of the paper [m/s^2]."""
INTENSITY = 0.1
"""Intensity varpi of the noise, in the convention of each case."""
REFERENCE = Sinusoid(amplitude=(1.5, 1.0), angular_frequency=(1.0, 2.0))
Q0 = (-0.1, 0.25)
"""Initial position [rad]."""
V0 = (-0.3, 0.45)
"""Initial velocity [rad/s]."""
RECORDED = ("u_command", "alpha", "abar")
"""Internal signals that the table and the figures need."""


@dataclass(frozen=True)
class Case:
    """One closed loop of the study.

    Attributes:
        plant: ``"corrected"``, the URDF arm shaken by a physical base acceleration, or
            ``"as printed"``, the paper's C and Lambda with their misprints.
        noise: Convention of the intensity varpi = 0.1: ``"psd"``, or ``"amplitude"`` as printed.
        kappa: Fractional power of the control law; 1 gives the asymptotic law of the paper's
            comparison.
        filter: ``"implicit"`` or ``"explicit"`` step of the command filter.
        period: Sampling period [s].
    """

    plant: Literal["corrected", "as printed"] = "corrected"
    noise: Convention = "amplitude"
    kappa: float = 0.6
    filter: Literal["implicit", "explicit"] = "implicit"
    period: float = 1e-3


FINITE_TIME = Case()
"""The paper's controller on the corrected plant, noise as printed: Figures 1-1, 1-2 and 2."""
ASYMPTOTIC = Case(kappa=1.0)
"""The asymptotic controller that Figure 2 compares it with."""
EXPLICIT = Case(filter="explicit")
"""The paper's controller with the explicit filter step that most simulations use."""

CASES = (
    FINITE_TIME,
    ASYMPTOTIC,
    Case(noise="psd"),
    Case(noise="psd", kappa=1.0),
    Case(plant="as printed"),
    Case(plant="as printed", kappa=1.0),
    Case(plant="as printed", noise="psd"),
    Case(plant="as printed", noise="psd", kappa=1.0),
    EXPLICIT,
    Case(filter="explicit", period=1e-4),
)
"""The whole study."""
QUICK_CASES = (FINITE_TIME, ASYMPTOTIC, Case(plant="as printed"), EXPLICIT)
"""Cases of a quick look: those of the figures, and the plant as printed."""


def closed_loop(case: Case) -> ClosedLoop:
    """The loop of a case; the nominal arm of its controller is always the corrected one."""
    nominal = load_arm("double_pendulum", gravity=GRAVITY)
    noise = WhiteNoise(INTENSITY, case.noise)
    as_printed = case.plant == "as printed"
    return ClosedLoop(
        arm=PaperPendulum(g=GRAVITY, as_printed=True) if as_printed else nominal,
        controller=printed(FTCF(nominal, Gains(kappa=case.kappa), filter=case.filter)),
        reference=REFERENCE,
        vibration=Vibration(PaperPendulumInput() if as_printed else BaseAcceleration("xz"), noise),
        period=case.period,
        q0=Q0,
        v0=V0,
    )


def run_case(case: Case, duration: float = DURATION) -> xr.Dataset:
    """Path 0 of a case over ``duration`` [s], with the signals that the table needs."""
    return simulate(closed_loop(case), duration, seed=SEED, signals=RECORDED)
