"""The paper's study (Section V) as data: its cases, how one runs, and the numbers of its table."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.control.ftcf import FTCF, Gains
from ftcfa.engine.simulate import simulate
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.references import Sinusoid
from ftcfa.model.pendulum import PaperPendulum
from ftcfa.model.urdf.load import load_arm
from ftcfa.statistics.settling import below_for_good
from ftcfa.vibration.excitations.white_noise import Convention, WhiteNoise
from ftcfa.vibration.inputs.noise_input import BaseAcceleration, PaperPendulumInput
from ftcfa.vibration.vibration import Vibration

DURATION = 20.0
"""Simulated time of the paper's figures [s]."""
QUICK_DURATION = 5.0
"""Simulated time of a quick look [s]."""
SEED = 0
BAND = 0.05
"""A path has settled once its overall tracking error stays below this [rad]."""
GRAVITY = 9.8
INTENSITY = 0.1
REFERENCE = Sinusoid(amplitude=(1.5, 1.0), angular_frequency=(1.0, 2.0))
Q0 = (-0.1, 0.25)
V0 = (-0.3, 0.45)
RECORDED = ("u_command", "alpha", "abar")
"""Internal signals that the table and the figures need."""

UNITS = {
    "period": "s",
    "rms_ote": "rad",
    "settled_after": "s",
    "largest_u": "N m",
    "saturated_share": "1",
    "largest_filter_error": "rad/s",
    "diverged_at": "s",
}
"""Units of the columns of `summary_row`."""


@dataclass(frozen=True)
class Case:
    """One closed loop of the study.

    Attributes:
        plant: ``"corrected"``, the URDF arm shaken by a physical base acceleration, or
            ``"as printed"``, the paper's C and Lambda with their misprints.
        noise: Convention of the intensity varpi = 0.1: ``"psd"``, or ``"amplitude"`` as printed.
        kappa: Fractional power; 1 is the asymptotic control that the paper compares with.
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
"""Its rival of Figure 2."""
EXPLICIT = Case(filter="explicit")
"""The paper's controller with the filter stepped as most simulations do."""

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
"""What a quick look shows: the cases of the figures, and the paper as printed."""


def closed_loop(case: Case) -> ClosedLoop:
    """The loop of a case; the controller's nominal arm is the corrected one, always."""
    nominal = load_arm("double_pendulum", gravity=GRAVITY)
    noise = WhiteNoise(INTENSITY, case.noise)
    printed = case.plant == "as printed"
    return ClosedLoop(
        arm=PaperPendulum(g=GRAVITY, as_printed=True) if printed else nominal,
        controller=FTCF(nominal, Gains(kappa=case.kappa), filter=case.filter),
        reference=REFERENCE,
        vibration=Vibration(PaperPendulumInput() if printed else BaseAcceleration("xz"), noise),
        period=case.period,
        q0=Q0,
        v0=V0,
    )


def run_case(case: Case, duration: float = DURATION) -> xr.Dataset:
    """Path 0 of a case over ``duration`` [s], with the signals that the table needs."""
    return simulate(closed_loop(case), duration, seed=SEED, signals=RECORDED)


def summary_row(case: Case, dataset: xr.Dataset) -> dict[str, Any]:
    """The row of a case in the table, as plain data; `UNITS` gives its units.

    A mean or maximum over the last half is None if the path diverged: the dead are not averaged
    away. The largest torque and the share of saturation are those of the time alive.
    """
    time, ote = dataset["time"].values, dataset["ote"].values
    u, command = np.abs(dataset["u"].values), np.abs(dataset["u_command"].values)
    filter_error = np.abs(dataset["abar"].values - dataset["alpha"].values)
    alive, last_half = np.isfinite(ote), time >= time[-1] / 2
    died = float(dataset["diverged_at"])
    return {
        "plant": case.plant,
        "noise": case.noise,
        "kappa": case.kappa,
        "filter": case.filter,
        "period": case.period,
        "rms_ote": _finite(np.sqrt(np.mean(ote[last_half] ** 2))),
        "settled_after": settled_after(time, ote),
        "largest_u": _finite(np.max(u[alive])),
        "saturated_share": _finite(np.mean(np.any(command[alive] > u[alive], axis=1))),
        "largest_filter_error": _finite(np.max(filter_error[last_half])),
        "diverged_at": _finite(died),
    }


def settled_after(time: Array, ote: Array, band: float = BAND) -> float | None:
    """Time after which the error stays below the band to the end of the run, or None.

    Args:
        time: Shape (T,) [s].
        ote: Overall tracking error, shape (T,) [rad]; NaN counts as outside.
        band: Half width [rad].
    """
    return _finite(below_for_good(time, ote, band))


def _finite(value: float | np.floating[Any]) -> float | None:
    return float(value) if np.isfinite(value) else None
