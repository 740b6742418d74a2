"""`ensemble`: the same numbers however it is run, and what an interruption leaves."""

import gc
import tracemalloc
from functools import partial

import numpy as np
import pytest
import xarray as xr
from small_loops import DURATION, oscillators, pendulum, uncertain_pendulum

from ftcfa import Interrupted, ensemble, replay, simulate_paths
from ftcfa.statistics.moments import Moments
from ftcfa.study.chunk import run_chunk
from ftcfa.study.plan import Plan
from ftcfa.study.tally import PairwiseMoments, Tally

PATHS, CHUNK = 1100, 300
"""Chunks of which the last is not full, nor a whole number of vectors."""
ROUNDING = 1e-9
"""Of sums in another order, relative."""

LOOPS = {"pendulum": pendulum, "uncertain": uncertain_pendulum}
run = partial(ensemble, paths=PATHS, duration=DURATION, chunk=CHUNK)


@pytest.fixture(params=LOOPS)
def loop(request):
    return LOOPS[request.param]()


def assert_close(a, b):
    """Equal to rounding; per path, bit for bit."""
    assert set(a.variables) == set(b.variables)
    for name, rows in a.variables.items():
        if "path" in rows.dims or rows.dtype.kind != "f":
            np.testing.assert_array_equal(rows, b[name], err_msg=name)
        else:
            scale = np.nanmax(np.abs(rows.values))
            np.testing.assert_allclose(
                rows, b[name], rtol=ROUNDING, atol=ROUNDING * scale, err_msg=name
            )


def test_the_same_bits_on_any_number_of_threads(loop):
    xr.testing.assert_identical(run(loop, threads=1), run(loop, threads=2))


@pytest.mark.parametrize("chunk", [64, 1000, PATHS])
def test_the_same_numbers_in_any_chunks(loop, chunk):
    assert_close(run(loop), run(loop, chunk=chunk))


def test_the_statistics_are_those_of_the_paths(loop):
    """NumPy on the trajectories themselves is the oracle."""
    dataset = run(loop, record_every=20)
    paths = simulate_paths(loop, PATHS, DURATION, record_every=20)
    rows = {"ote": paths["ote"], "error": paths["q"] - paths["q_d"], "u": paths["u"]}
    for name, row in rows.items():
        for statistic, truth in (
            ("mean", row.mean("path")),
            ("mean_square", (row**2).mean("path")),
        ):
            found = dataset[f"{name}_{statistic}"].sel(bound="estimate")
            np.testing.assert_allclose(found, truth.transpose(*found.dims), rtol=ROUNDING)
        exact = np.quantile(row.transpose("path", ...), [0.05, 0.5], axis=0, method="inverted_cdf")
        found = dataset[f"{name}_quantile"].sel(bound="estimate", quantile=[0.05, 0.5])
        np.testing.assert_allclose(found, exact, rtol=1 / 256)


def test_a_path_can_be_replayed():
    dataset = run(uncertain_pendulum())
    path = replay(dataset, 700)
    np.testing.assert_array_equal(
        dataset["peak_torque"].sel(path=700), np.abs(path["u"]).max("time").values
    )


def test_chunks_add_up_to_the_same_bits_in_any_order():
    loop, plan = pendulum(), Plan(DURATION, chunk=16)
    observed = plan.observed(loop)
    parts = {k: run_chunk(observed, plan, plan.paths_of(k, 170)) for k in plan.chunks(170)}
    results = []
    for seed in range(3):
        tally = Tally(len(plan.times(loop)), loop.arm.n)
        for k in np.random.default_rng(seed).permutation(len(parts)):
            tally.add(int(k), parts[int(k)])
        sums = [
            getattr(m, name) for m in tally.moments for name in ("count", "average", "M2", "M3")
        ]
        results.append((sums, tally.sketch.counts, tally.per_path))
    for sums, counts, per_path in results[1:]:
        for a, b in zip(sums, results[0][0], strict=True):
            np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(counts, results[0][1])
        xr.testing.assert_identical(per_path, results[0][2])


def test_what_is_held_does_not_grow_with_the_number_of_chunks():
    merging, rng, rows = PairwiseMoments(), np.random.default_rng(0), []
    for number in range(1000):
        rows.append(rng.standard_normal(3))
        merging.add(number, Moments.of(rows[-1][:, None]))
        assert len(merging._parts) <= 10  # log2 of 1,000
    x = np.concatenate(rows)
    np.testing.assert_allclose(merging.total.mean, x.mean(), rtol=ROUNDING)
    np.testing.assert_allclose(merging.total.variance, x.var(ddof=1), rtol=ROUNDING)


def test_memory_grows_by_what_is_reported_of_each_path():
    """Not by records, sketches or sums of the chunks that are done."""
    held, loop = [], pendulum()
    ensemble(loop, 128, 0.02)  # compiles

    def look(done, _):
        gc.collect()
        held.append((done, tracemalloc.get_traced_memory()[0]))

    tracemalloc.start()
    try:
        dataset = ensemble(loop, 12 * 128, 0.02, chunk=128, progress=look)
    finally:
        tracemalloc.stop()
    reported = sum(x.nbytes for x in dataset.variables.values() if "path" in x.dims) / (12 * 128)
    (first, before), (last, after) = held[3], held[-1]
    assert (after - before) / (last - first) < 1.5 * reported  # beside it, a few objects a chunk


class CtrlC:
    """A progress that is interrupted after some chunks."""

    def __init__(self, chunks):
        self.left = chunks

    def __call__(self, done, paths):
        self.left -= 1
        if not self.left:
            raise KeyboardInterrupt


def test_an_interrupt_carries_the_statistics_of_what_is_done(tmp_path):
    """The first chunks, whole; then the same call goes on from there."""
    loop, store = pendulum(), tmp_path / "store"
    with pytest.raises(Interrupted, match="ensemble interrupted; what is done is in") as caught:
        run(loop, store=store, progress=CtrlC(3))
    part = caught.value.partial
    assert part.sizes["path"] in (2 * CHUNK, 3 * CHUNK)
    xr.testing.assert_identical(part, run(loop, paths=part.sizes["path"]))
    xr.testing.assert_identical(
        xr.open_zarr(store, group="result", consolidated=False).load(), part
    )
    done = []
    whole = run(loop, store=store, progress=lambda paths, _: done.append(paths))
    xr.testing.assert_identical(whole, run(loop))
    assert done[-1] == PATHS


def test_an_interrupt_before_anything_is_done_carries_nothing(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("ftcfa.study.ensemble.simulate_chunk", interrupted)
    with pytest.raises(Interrupted, match="ensemble interrupted; nothing is done") as caught:
        run(pendulum())
    assert caught.value.partial is None


def test_divergence_is_counted_and_shows_in_the_mean():
    dataset = run(oscillators(1, -100.0, 0.0), duration=3.0)
    assert dataset.attrs["diverged"] == np.isfinite(dataset["diverged_at"]).sum() > 0
    assert np.isnan(dataset["ote_mean"].sel(bound="estimate")[-1])
    assert np.isfinite(dataset["ote_mean"].sel(bound="estimate")[1])
