"""The summary of an ensemble: statistics over time and metrics of each path, as one Dataset."""

import json
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.control.protocol import Quantity
from ftcfa.description.read import rebuild
from ftcfa.description.write import provenance
from ftcfa.engine.dataset import attributes, versions
from ftcfa.engine.run import Engine
from ftcfa.engine.simulate import simulate
from ftcfa.errors import ExperimentError, ParameterError
from ftcfa.hardware.hardware import Hardware
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.command import LOOP_QUANTITIES
from ftcfa.statistics.kaplan_meier import SettlingDistribution, settling_distribution
from ftcfa.statistics.settling import practical_settling_time
from ftcfa.study.chunk import PER_JOINT
from ftcfa.study.diagnosis import diagnosis
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import OUTCOMES, VARIABLES, WORDS
from ftcfa.study.plan import Plan
from ftcfa.study.tally import Tally

TRACKING_ERROR = Quantity("rad", "tracking error")
DIVERGED_AT = {"units": "s", "long_name": "time of divergence, NaN if none"}
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
BOUNDS = ("estimate", "low", "high")
"""Value of a statistic and the ends of its confidence interval."""
NOT_DIVERGED = "_not_diverged"
"""End of the name of a statistic over the paths that have not diverged."""


def summarise(
    loop: ClosedLoop, plan: Plan, tally: Tally, quantiles: Sequence[float], confidence: float
) -> xr.Dataset:
    """The statistics of an ensemble.

    Returns:
        A Dataset. Over time, for the overall tracking error ``ote`` and for each joint's ``error``
        q - q_d and torque ``u``: ``*_mean``, ``*_mean_square`` and ``*_quantile``, with a
        dimension ``bound`` (estimate, low, high). A path that has diverged makes means undefined
        (NaN) and counts as the largest of all in quantiles; ``*_mean_not_diverged`` and
        ``*_mean_square_not_diverged`` are over the other paths. ``ote_mean_square_by_few`` says
        when so few paths carry the mean square of ``ote`` that its interval may miss it
        (`Moments.carried_by`). For each path: its metrics (see
        `ftcfa.study.metrics.table`), what became of it (`ftcfa.study.outcomes.VARIABLES`) and
        ``diverged_at``. Attributes: the number of paths of each outcome, and a ``diagnosis`` where
        more than 1 % are not kept.
    """
    value, square = tally.moments
    with np.errstate(invalid="ignore"):
        estimates = {
            "mean": value.student(confidence),
            f"mean{NOT_DIVERGED}": value.without_missing().student(confidence),
            "mean_square": square.skewness_corrected(confidence),
            f"mean_square{NOT_DIVERGED}": square.without_missing().skewness_corrected(confidence),
        }
    data: dict[str, Any] = {}
    for statistic, estimate in estimates.items():
        data |= _over_time(loop, statistic, ("bound",), np.stack(estimate))
    few = square.without_missing().carried_by()[:, 0]
    meaning = "whether few paths carry the mean square of the overall tracking error"
    data["ote_mean_square_by_few"] = ("time", few, {"units": "", "long_name": meaning})
    levels = np.asarray(quantiles, dtype=float)
    quantile = np.stack(tally.sketch.quantile(levels, confidence))
    data |= _over_time(loop, "quantile", ("bound", "quantile"), quantile)
    per_path = tally.per_path[[*METRICS, *VARIABLES, "diverged_at"]]
    for name, metric in METRICS.items():
        per_path[name].attrs = attributes(loop, metric.unit, metric.meaning, metric.per_joint)
    for name, (unit, meaning) in VARIABLES.items():
        per_path[name].attrs = {"units": unit, "long_name": meaning}
    flags = {"flag_values": list(range(len(OUTCOMES))), "flag_meanings": " ".join(WORDS)}
    per_path["outcome"].attrs |= flags
    per_path["diverged_at"].attrs = DIVERGED_AT
    times = plan.times(loop)
    q_d = loop.desired(times).q
    data |= _limits(loop)
    data["q_d"] = (("time", "joint"), q_d, attributes(loop, *LOOP_QUANTITIES["q_d"], True))
    dataset = xr.Dataset(
        data,
        coords={
            "time": ("time", times, {"units": "s"}),
            "joint": list(loop.arm.joint_names),
            "joint_type": ("joint", list(loop.arm.joint_types)),
            "quantile": levels,
            "bound": list(BOUNDS),
        },
        attrs={
            **versions(),
            "experiment": json.dumps(provenance(loop)),
            "hardware": loop.interface.name,
            "duration": plan.duration,
            "seed": plan.seed,
            "tolerance": plan.tolerance,
            "after": plan.late,
            "chunk": plan.chunk,
            "confidence": confidence,
            **{word: int(np.sum(per_path["outcome"] == k)) for k, word in enumerate(WORDS)},
        },
    )
    dataset = dataset.assign(per_path.data_vars)
    return dataset.assign_attrs(diagnosis=diagnosis(loop, dataset))


def _limits(loop: ClosedLoop) -> dict[str, Any]:
    """The limits of torque and torque rate that hold for each joint; infinite where none does."""
    hardware = loop.hardware
    rate = hardware.actuators.rate_limit if isinstance(hardware, Hardware) else np.inf
    limits = {
        "effort_limit": (loop.interface.limit(loop.arm.effort_limit), "N m", "largest torque"),
        "torque_rate_limit": (rate, "N m/s", "largest rate at which the driver changes the torque"),
    }
    return {
        name: ("joint", np.full(loop.arm.n, values), attributes(loop, unit, meaning, True))
        for name, (values, unit, meaning) in limits.items()
    }


def replay(
    dataset: xr.Dataset, path: int, *, loop: ClosedLoop | None = None, engine: Engine = "compiled"
) -> xr.Dataset:
    """Simulate one path of an ensemble again, with every internal signal.

    Args:
        dataset: The Dataset of `ensemble`, or the one read from its store.
        path: Number of the path.
        loop: The loop that ran; needed where it has a user's own part, which the Dataset does not
            describe.
        engine: The engine, as in `simulate`.

    Raises:
        ParameterError: If the Dataset does not describe its whole loop.
    """
    attrs = dataset.attrs
    if loop is None:
        try:
            loop = rebuild(ClosedLoop, json.loads(attrs["experiment"]), "experiment", Path())
        except ExperimentError as error:
            got = "a Dataset that does not describe its whole loop"
            remedy = "give loop=, the loop that ran"
            raise ParameterError("replay", got, remedy=remedy) from error
    duration, seed = attrs["duration"], int(attrs["seed"])
    return simulate(loop, duration, seed=seed, path=path, signals="all", engine=engine)


def settling(dataset: xr.Dataset) -> SettlingDistribution:
    """Distribution of the settling time over an ensemble's paths (Kaplan-Meier).

    All runs end together, so that the band is exact.

    Args:
        dataset: The Dataset of `ensemble`.
    """
    times = dataset["settling_time"].values
    return settling_distribution(
        np.where(np.isfinite(times), times, np.nan),
        dataset.attrs["duration"],
        np.isfinite(dataset["diverged_at"].values),
        dataset.attrs["confidence"],
    )


def settled_in_mean_square(dataset: xr.Dataset, epsilon: float) -> float:
    """Settling time in mean square (practical finite-time stability, Definition 1) from paths.

    The earliest recorded time from which the upper confidence bound of E|z1|^2 stays below epsilon,
    z1 = q - q_d; see `ftcfa.statistics.settling`. Where few paths carry the mean square when its
    bound is largest, a warning says so: the bound of 97.5 % then holds less often: that of
    lognormal values in 93 % of the cases with 20 paths, 96 % with 100 and 97 % with 500, and where
    1 % of the paths fail, in 62, 64 and 99 % (``scripts/coverage_table.py``).

    Args:
        dataset: The Dataset of `ensemble`.
        epsilon: Bound of the mean square [rad^2 or m^2].

    Returns:
        T [s], or NaN if the bound is not below epsilon at the end.
    """
    time, bound = dataset["time"].values, dataset["ote_mean_square"].sel(bound="high").values
    settled = practical_settling_time(time, bound, epsilon)
    after = np.flatnonzero(time >= settled)
    if after.size:
        k = after[np.argmax(bound[after])]
        if dataset["ote_mean_square_by_few"].values[k]:
            warnings.warn(
                f"the mean square error at {time[k]:g} s is carried by few of the "
                f"{dataset.sizes['path']:,} paths, and its bound may be too small; run more paths",
                stacklevel=2,
            )
    return settled


def _over_time(
    loop: ClosedLoop, statistic: str, dims: tuple[str, ...], values: Array
) -> dict[str, tuple[tuple[str, ...], Array, dict[str, str]]]:
    """Variables of a statistic over time; its values have the shape (*dims, time, quantity)."""
    phrase = statistic.removesuffix(NOT_DIVERGED).replace("_", " ")
    paths = " over the paths that have not diverged" if statistic.endswith(NOT_DIVERGED) else ""

    def label(unit: str, meaning: str, per_joint: bool) -> dict[str, str]:
        if "mean square" in phrase:
            unit = f"({unit})^2" if " " in unit else f"{unit}^2"
        return attributes(loop, unit, f"{phrase} of {meaning}{paths}", per_joint)

    ote, *joints = np.split(values, [1 + k * loop.arm.n for k in range(len(PER_JOINT))], axis=-1)
    overall = label("rad", "overall tracking error |q - q_d|", False)
    variables = {f"ote_{statistic}": ((*dims, "time"), ote[..., 0], overall)}
    for name, part in zip(PER_JOINT, joints, strict=True):
        unit, meaning = LOOP_QUANTITIES.get(name, TRACKING_ERROR)
        labels = label(unit, meaning, True)
        variables[f"{name}_{statistic}"] = ((*dims, "time", "joint"), part, labels)
    return variables
