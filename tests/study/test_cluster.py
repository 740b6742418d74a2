"""Ensembles on real clusters: worker processes, by address, killed, of another version."""

import os
import signal
import subprocess
import sys

import pytest
import xarray as xr
from small_loops import DURATION, oscillators, pendulum, uncertain_pendulum

from ftcfa import ensemble
from ftcfa.errors import FtcfaError, ParameterError

distributed = pytest.importorskip("distributed")

PATHS, CHUNK = 1100, 100
OTHER_VERSION = """
import importlib.metadata as metadata
true = metadata.version
metadata.version = lambda name: "0.0.1" if name == "ftcfa" else true(name)
"""
NO_FTCFA = """
import importlib.metadata as metadata
true = metadata.version
def version(name):
    if name == "ftcfa":
        raise metadata.PackageNotFoundError(name)
    return true(name)
metadata.version = version
"""


def run(loop, **options):
    return ensemble(loop, PATHS, DURATION, chunk=CHUNK, **options)


class Cluster:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.file = folder / "scheduler.json"
        self.processes = []
        self._start("dask_scheduler", "--port", "0")
        self.client = None

    def _start(self, tool, *options):
        command = [sys.executable, "-m", f"distributed.cli.{tool}", "--no-dashboard"]
        command += ["--scheduler-file", str(self.file), *options]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        process = subprocess.Popen(
            command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.processes.append(process)
        return process

    def worker(self, *options):
        return self._start("dask_worker", "--nthreads", "1", "--no-nanny", *options)

    def connect(self, workers):
        client = distributed.Client(scheduler_file=str(self.file), timeout=60)
        client.wait_for_workers(workers, timeout=60)
        return distributed.Client(client.scheduler.address), client

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.close()


def test_a_cluster_in_this_machine():
    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**settings) as local, distributed.Client(local) as client:
        for make in (pendulum, uncertain_pendulum):
            xr.testing.assert_identical(run(make(), client=client), run(make()))


def test_a_cluster_by_address_and_a_worker_killed_in_the_middle(cluster, tmp_path):
    victim, _ = cluster.worker(), cluster.worker()
    client, first = cluster.connect(2)
    try:
        loop = uncertain_pendulum()
        expected = run(loop)
        xr.testing.assert_identical(run(loop, client=client), expected)

        chunks = []

        def kill(done, paths):
            chunks.append(done)
            if 0 < done < paths and victim.poll() is None:
                victim.send_signal(signal.SIGKILL)
                victim.wait()

        store = tmp_path / "store"
        result = run(loop, client=client, store=store, progress=kill)
        assert victim.poll() == -signal.SIGKILL
        xr.testing.assert_identical(result, expected)
        xr.testing.assert_identical(run(loop, store=store), expected)  # what it stored is sound
    finally:
        client.close()
        first.close()


@pytest.mark.parametrize(
    ("disguise", "found"), [(OTHER_VERSION, "ftcfa 0.0.1"), (NO_FTCFA, "no f")]
)
def test_workers_with_another_ftcfa_are_refused(cluster, tmp_path, disguise, found):
    preload = tmp_path / "disguise.py"
    preload.write_text(disguise)
    cluster.worker("--preload", str(preload))
    client, first = cluster.connect(1)
    try:
        with pytest.raises(FtcfaError, match=rf"worker tcp://.*: {found}.*, expected ftcfa .*; "):
            run(pendulum(), client=client)
    finally:
        client.close()
        first.close()


def test_workers_that_compute_other_bits_are_refused(cluster, tmp_path):
    preload = tmp_path / "disguise.py"
    preload.write_text("import ftcfa.study.probe\nftcfa.study.probe.SAMPLES = 31\n")
    cluster.worker("--preload", str(preload))
    client, first = cluster.connect(1)
    try:
        with pytest.raises(FtcfaError, match=r"worker tcp://.*: other last bits than here: probe "):
            run(pendulum(), client=client)
    finally:
        client.close()
        first.close()


def test_a_cluster_that_breaks_down_is_one_sentence(cluster, tmp_path):
    cluster.worker()
    client, first = cluster.connect(1)

    def kill(done, paths):
        if 0 < done < paths:
            cluster.close()

    try:
        with pytest.raises(FtcfaError, match=r"cluster: broke down \(.*\); repair it"):
            run(pendulum(), client=client, progress=kill, store=tmp_path / "store")
    finally:
        client.close(timeout=1)
        first.close(timeout=1)
    loop = pendulum()
    xr.testing.assert_identical(run(loop, store=tmp_path / "store"), run(loop))


def test_threads_are_the_clusters_own():
    with pytest.raises(ParameterError, match="threads: given together with client"):
        run(pendulum(), client=object(), threads=2)


def test_a_part_of_a_users_own_cannot_travel():
    with pytest.raises(ParameterError, match="a part of ftcfa"):
        run(oscillators(1, 1.0, 1.0), client=object())
