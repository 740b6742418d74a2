"""The table of metrics: what every metric must satisfy, and that a new one needs only its line."""

from dataclasses import replace

import numpy as np
import pytest
from small_loops import DURATION, pendulum

from ftcfa import ensemble, simulate_paths
from ftcfa.engine.compiler.flatten import leaves, like
from ftcfa.study.metrics.compared import COMPARED
from ftcfa.study.metrics.metric import Metric
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.path_metrics import PathMetrics

JOINTS, PATHS, PERIOD = 3, 5, 1e-3
PEAK_SPEED = Metric(
    label="peak speed",
    unit="rad/s",
    meaning="largest speed",
    step=lambda peak, sample: np.maximum(peak, np.abs(sample.signals["v"])),
    result=lambda peak, _: peak,
    per_joint=True,
)
SMALLEST_SPEED = Metric(
    label="smallest speed",
    unit="rad/s",
    meaning="smallest norm of the joint speeds",
    step=lambda least, sample: np.minimum(least, np.linalg.norm(sample.signals["v"])),
    result=lambda least, _: least,
    start=np.inf,
)


def observed(samples, seed=0):
    """Counts of random samples."""
    observer, rng = PathMetrics(1.0, after=2 * PERIOD), np.random.default_rng(seed)
    counts = observer.init(JOINTS)
    for _ in range(samples):
        names = ("q", "q_d", "v", "u", "u_command", "u_wanted")
        signals = {name: rng.standard_normal(JOINTS) for name in names}
        counts = observer.step(counts, signals, PERIOD)
    return observer, counts


@pytest.mark.parametrize("name", METRICS)
def test_a_metric_is_described_and_keeps_the_shape_of_its_counter(name):
    metric, index = METRICS[name], list(METRICS).index(name)
    assert metric.label
    assert metric.unit
    assert metric.meaning
    shape = (JOINTS,) if metric.per_joint else (1,)
    for samples in (0, 1, 4):
        assert np.shape(observed(samples)[1].metrics[index]) == shape


@pytest.mark.parametrize("name", METRICS)
def test_results_are_one_a_path_or_joint_and_nan_where_a_path_diverged(name):
    parts = [observed(4, seed)[1] for seed in range(PATHS)]
    observer, one = observed(4)
    states = [leaves(part) for part in parts]
    stacked = [np.stack(rows) for rows in zip(*states, strict=True)]
    for row in stacked:
        row[-1] = np.nan
    counts = like(one, iter(stacked))
    values = observer.results(counts, PERIOD)[name]
    assert values.shape == ((PATHS, JOINTS) if METRICS[name].per_joint else (PATHS,))
    assert np.all(np.isnan(values[-1]))


def test_a_metric_by_which_loops_are_compared_is_described():
    for metric in COMPARED.values():
        assert metric.unit
        assert metric.meaning


def test_a_new_metric_is_one_entry_of_the_table(monkeypatch):
    """It is compiled with the loop and reaches the Dataset, with unit and meaning."""
    monkeypatch.setitem(METRICS, "peak_speed", PEAK_SPEED)
    monkeypatch.setitem(METRICS, "smallest_speed", SMALLEST_SPEED)
    loop = replace(pendulum())  # traced with these metrics
    dataset = ensemble(loop, PATHS, DURATION)
    v = simulate_paths(pendulum(), PATHS, DURATION).v
    np.testing.assert_array_equal(dataset.peak_speed, np.abs(v).max("time"))
    least = np.sqrt((v**2).sum("joint")).min("time")
    np.testing.assert_allclose(dataset.smallest_speed, least, rtol=1e-14)
    assert dataset.peak_speed.attrs == {"units": "rad/s", "long_name": "largest speed"}
