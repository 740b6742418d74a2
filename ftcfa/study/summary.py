"""What an ensemble amounts to: statistics over time and of each path, as one Dataset."""

import json
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.control.protocol import Quantity
from ftcfa.description.faults import ExperimentError
from ftcfa.description.read import rebuild
from ftcfa.description.write import provenance
from ftcfa.engine.dataset import attributes
from ftcfa.engine.run import Engine
from ftcfa.engine.simulate import simulate
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import LOOP_QUANTITIES, ClosedLoop
from ftcfa.statistics.estimate import Estimate
from ftcfa.statistics.kaplan_meier import SettlingDistribution, settling_distribution
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.settling import practical_settling_time
from ftcfa.study.chunk import PER_JOINT, Plan, Tally
from ftcfa.study.path_metrics import UNITS as METRICS

TRACKING_ERROR = Quantity("rad", "tracking error")
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
BOUNDS = ("estimate", "low", "high")
"""Of every statistic: its value and the ends of its confidence interval."""


def summarise(
    loop: ClosedLoop, plan: Plan, tally: Tally, quantiles: Sequence[float], confidence: float
) -> xr.Dataset:
    """The statistics of an ensemble.

    Returns:
        A Dataset. Over time, for the overall tracking error ``ote`` and for each joint's ``error``
        q - q_d and torque ``u``: ``*_mean``, ``*_mean_square`` and ``*_quantile``, with a
        dimension ``bound`` (estimate, low, high). A path that has diverged leaves means undefined
        (NaN) and counts as the largest of all in quantiles; ``*_survivors`` leave such paths
        out. For each path: its metrics (see `ftcfa.study.path_metrics`) and ``diverged_at``.
    """
    value, square = tally.moments
    with np.errstate(invalid="ignore"):
        estimates = {
            "mean": value.student(confidence),
            "mean_survivors": value.survivors().student(confidence),
            "mean_square": square.skewness_corrected(confidence),
            "mean_square_survivors": square.survivors().skewness_corrected(confidence),
        }
    data: dict[str, Any] = {}
    for statistic, estimate in estimates.items():
        data |= _over_time(loop, statistic, ("bound",), np.stack(estimate))
    levels = np.asarray(quantiles, dtype=float)
    found = np.stack(tally.sketch.quantile(levels, confidence))
    data |= _over_time(loop, "quantile", ("bound", "quantile"), found)
    per_path = tally.per_path
    metrics = {**METRICS, "diverged_at": ("s", "time of divergence, NaN if none")}
    for name, told in metrics.items():
        per_path[name].attrs = attributes(loop, *told, "joint" in per_path[name].dims)
    times = plan.times(loop)
    q_d = loop.reference.at(times).q
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
            "ftcfa_version": version("ftcfa"),
            "experiment": json.dumps(provenance(loop)),
            "duration": plan.duration,
            "seed": plan.seed,
            "tolerance": plan.tolerance,
            "after": plan.late,
            "chunk": plan.chunk,
            "confidence": confidence,
            "diverged": int(np.isfinite(per_path["diverged_at"]).sum()),
        },
    )
    return dataset.assign({name: per_path[name] for name in metrics})


def replay(
    dataset: xr.Dataset, path: int, *, loop: ClosedLoop | None = None, engine: Engine = "compiled"
) -> xr.Dataset:
    """Simulate one path of an ensemble again, with every internal signal.

    Args:
        dataset: What `ensemble` returned, or what was read from its store.
        path: The path's number.
        loop: The loop, where it has parts of a user's own, which no file can tell.
        engine: As in `simulate`.

    Raises:
        ParameterError: If the loop cannot be made of what the dataset tells.
    """
    told = dataset.attrs
    if loop is None:
        try:
            loop = rebuild(ClosedLoop, json.loads(told["experiment"]), "experiment", Path())
        except ExperimentError as error:
            raise ParameterError(
                "replay",
                "a dataset that does not tell all of its loop",
                remedy="give loop=, the loop that ran",
            ) from error
    return simulate(
        loop, told["duration"], seed=int(told["seed"]), path=path, signals="all", engine=engine
    )


def settling(dataset: xr.Dataset) -> SettlingDistribution:
    """Distribution of the settling time over an ensemble's paths (Kaplan-Meier).

    All runs end together, so nothing is censored before the end and the share that has settled is
    binomial: where none or all have, the band ends at Clopper and Pearson's exact bound.

    Args:
        dataset: What `ensemble` returned.
    """
    times, confidence = dataset["settling_time"].values, dataset.attrs["confidence"]
    found = settling_distribution(
        np.where(np.isfinite(times), times, np.nan),
        dataset.attrs["duration"],
        np.isfinite(dataset["diverged_at"].values),
        confidence,
    )
    value, low, high = found.share
    _, all_settled, _ = proportion(times.size, times.size, confidence)
    low = np.where(value >= 1.0, np.maximum(low, all_settled), low)
    high = np.where(value <= 0.0, np.minimum(high, 1.0 - all_settled), high)
    return replace(found, share=Estimate(value, low, high))


def settled_in_mean_square(dataset: xr.Dataset, epsilon: float) -> float:
    """Practical finite-time stability in mean square (Definition 1), as far as paths show it.

    The earliest kept time from which the upper confidence bound of E|z1|^2 stays below epsilon;
    see `ftcfa.statistics.settling`.

    Args:
        dataset: What `ensemble` returned.
        epsilon: [rad^2 or m^2].

    Returns:
        T [s], or NaN if the bound is not below epsilon at the end.
    """
    bound = dataset["ote_mean_square"].sel(bound="high").values
    return practical_settling_time(dataset["time"].values, bound, epsilon)


def _over_time(
    loop: ClosedLoop, statistic: str, dims: tuple[str, ...], values: Array
) -> dict[str, tuple[tuple[str, ...], Array, dict[str, str]]]:
    """Variables of a statistic whose values have the shape (..., time, quantity)."""
    n = loop.arm.n
    columns = np.split(values, [1 + k * n for k in range(len(PER_JOINT))], axis=-1)
    names = zip(("ote", *PER_JOINT), columns, strict=True)
    told = {}
    for name, part in names:
        unit, meaning = LOOP_QUANTITIES.get(name, TRACKING_ERROR)
        meaning = "overall tracking error |q - q_d|" if name == "ote" else meaning
        if "mean_square" in statistic:
            unit = f"({unit})^2" if " " in unit else f"{unit}^2"
        label = attributes(loop, unit, f"{statistic} of {meaning}", name != "ote")
        if name == "ote":
            told[f"ote_{statistic}"] = ((*dims, "time"), part[..., 0], label)
        else:
            told[f"{name}_{statistic}"] = ((*dims, "time", "joint"), part, label)
    return told
