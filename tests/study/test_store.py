"""The store of an ensemble: killed, full, damaged, of another experiment, shared, grown."""

import errno
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_loops import DURATION, oscillators, pendulum, read_all, uncertain_pendulum

from ftcfa import Sinusoid, ensemble, simulate
from ftcfa.engine import compiled
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.study.store import Store, discard
from tests.engine.targets import TARGETS

PATHS, CHUNK = 250, 100
SMALL = 1 << 20
"""Size of a small disk: less than the store takes [bytes]."""

run = partial(ensemble, paths=PATHS, duration=DURATION, chunk=CHUNK)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A loop, its store, finished, and what `ensemble` returned."""
    loop, store = pendulum(), tmp_path_factory.mktemp("finished") / "store"
    return loop, store, run(loop, store=store)


@pytest.fixture
def store(finished, tmp_path):
    """A copy of it to spoil."""
    shutil.copytree(finished[1], tmp_path / "store")
    return tmp_path / "store"


def inodes(store):
    """What shows whether chunks were written anew."""
    return {it.name: it.stat().st_ino for it in (store / "chunks").iterdir() if it.is_dir()}


def test_plain_xarray_reads_it(finished):
    _, store, result = finished
    groups = read_all(store)
    assert set(groups) == {"result", "chunks/000000", "chunks/000001", "chunks/000002"}
    xr.testing.assert_identical(groups["result"], result)
    assert groups["result"]["ote_mean"].attrs["units"] == "rad"
    per_path = xr.concat([groups[f"chunks/{k:06d}"]["energy"] for k in range(3)], "path")
    np.testing.assert_array_equal(per_path, result["energy"])


def test_a_finished_run_is_read_not_run_again(finished, store):
    loop, _, result = finished
    before = inodes(store)
    xr.testing.assert_identical(run(loop, store=store), result)
    assert inodes(store) == before


@pytest.mark.parametrize("kills", [4, pytest.param(20, marks=pytest.mark.slow)])
def test_kill_9_at_random_moments(tmp_path, kills):
    """`killed.py` looks at the store after each, and at every result."""
    script = Path(__file__).with_name("killed.py")
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path), str(kills), "0"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) == kills


PATIENCE = 50
"""Number of chunks after which Ctrl-C is pressed again."""


def test_ctrl_c_from_the_terminal(tmp_path):
    """SIGINT to a whole process: it goes on from what the store holds."""
    script = (
        "import sys; from small_loops import *; from ftcfa import Interrupted, ensemble\n"
        "try:\n"
        "    ensemble(pendulum(), 100_000, 1.0, chunk=100, threads=1, store=sys.argv[1],"
        " progress=lambda *_: print('done', flush=True))\n"
        "except Interrupted as stop:\n"
        "    print(stop.partial.sizes['path'])"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, "-c", script, str(tmp_path / "store")]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        for _ in range(3):
            assert process.stdout.readline() == "done\n"
        process.send_signal(signal.SIGINT)
        for number, line in enumerate(process.stdout):
            if line == "done\n" and number % PATIENCE == PATIENCE - 1:  # a library swallowed it
                process.send_signal(signal.SIGINT)
        paths = int(line)
    assert process.returncode == 0
    assert len(inodes(tmp_path / "store")) == paths / 100
    assert read_all(tmp_path / "store")["result"].sizes["path"] == paths


def check_resumes(loop, store):
    """Whatever went wrong, the store can be read, and the run goes on to the right result."""
    read_all(store)
    xr.testing.assert_identical(run(loop, store=store), run(loop))
    assert not list(store.rglob("*.part"))


@contextmanager
def small_disk(folder):
    """A file system of its own, unless this system does not let us."""
    folder.mkdir()
    options = ["-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(folder)]
    mount = subprocess.run(["mount", *options], capture_output=True, text=True, check=False)
    if mount.returncode != 0:
        pytest.skip(f"may not mount a small disk: {mount.stderr.strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk_is_one_sentence_and_the_run_goes_on(tmp_path):
    loop, disk = uncertain_pendulum(), tmp_path / "disk"
    with small_disk(disk):
        ballast = disk / "ballast"
        free = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
        ballast.write_bytes(bytes(free // 2))
        with pytest.raises(FtcfaError, match=r"store: cannot be written \(no space left on dev"):
            run(loop, store=disk / "store")
        read_all(disk / "store")
        ballast.unlink()
        subprocess.run(["mount", "-o", f"remount,size={16 * SMALL}", str(disk)], check=True)
        check_resumes(loop, disk / "store")


def test_files_that_may_not_grow(tmp_path):
    """The system's own refusal, which needs no rights: a limit on the size of files."""
    loop, store = pendulum(), tmp_path / "store"
    run(loop)  # what is imported and compiled on the way is written without limit
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(FtcfaError, match=r"cannot be written \(file too large\)"):
            run(loop, store=store)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    check_resumes(loop, store)


@pytest.mark.parametrize("writes", [0, 1, 30, 60, 150, 250])
def test_a_disk_that_is_full_after_some_writes(tmp_path, monkeypatch, writes):
    """While the folder is made, in a chunk, or in the result."""
    import zarr.storage._local as disk

    loop, store, put, left = pendulum(), tmp_path / "store", disk._put, [writes]

    def full(*arguments, **options):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return put(*arguments, **options)

    with monkeypatch.context() as patched:
        patched.setattr(disk, "_put", full)
        with pytest.raises(FtcfaError, match=r"no space left on device\); the stored chunks are"):
            run(loop, store=store)
    assert store.exists() or not list(tmp_path.iterdir())
    if store.exists():
        read_all(store)
    check_resumes_after = run(loop, store=store)
    xr.testing.assert_identical(check_resumes_after, run(loop))


def test_a_folder_that_may_not_be_written(finished, tmp_path):
    if os.geteuid() == 0:
        folder = Path("/proc/store")
    else:
        folder = tmp_path / "closed" / "store"
        folder.parent.mkdir(mode=0o500)
    with pytest.raises(FtcfaError, match=r"store: cannot be written \(.*\); "):
        run(finished[0], store=folder)


def test_a_file_in_place_of_a_folder(finished, tmp_path):
    file = tmp_path / "store"
    file.write_text("precious")
    with pytest.raises(ParameterError, match="store: no store of an ensemble, expected a new fold"):
        run(finished[0], store=file)
    assert file.read_text() == "precious"


def test_a_folder_of_something_else_stays_as_it_is(finished, tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(ParameterError, match="no store of an ensemble, expected a new folder"):
        run(finished[0], store=tmp_path)
    assert [it.name for it in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_empty_folder_will_do(finished, tmp_path):
    xr.testing.assert_identical(run(finished[0], store=tmp_path), finished[2])


@pytest.mark.parametrize(
    ("change", "options", "differ"),
    [
        (
            {"reference": Sinusoid((1.5, 1.0), (1.0, 3.0))},
            {},
            r"loop\.reference\.angular_frequency",
        ),
        ({"period": 2e-3}, {}, r"loop\.period"),
        ({}, {"seed": 1}, r"plan\.seed"),
        ({}, {"chunk": 50}, r"plan\.chunk"),
        ({}, {"duration": 0.2}, r"plan\.duration"),
        ({}, {"tolerance": 0.1}, r"plan\.tolerance"),
    ],
)
def test_a_store_of_another_experiment_is_refused(finished, store, change, options, differ):
    before = read_all(store)
    with pytest.raises(
        ParameterError, match=rf"a store of another experiment \(they differ in {differ}\), exp"
    ):
        run(replace(finished[0], **change), store=store, **options)
    assert set(read_all(store)) == set(before)


def test_a_part_of_a_users_own_with_other_numbers_is_another_experiment(tmp_path):
    """No description tells its gains; the first samples of the first paths do."""
    first, other = (oscillators(1, k, 1.0) for k in (100.0, 101.0))
    run(first, store=tmp_path / "store")
    with pytest.raises(ParameterError, match=r"paths come out with other bits \(another probe\)"):
        run(other, store=tmp_path / "store")
    run(oscillators(1, 100.0, 1.0), store=tmp_path / "store")


def test_a_store_goes_on_at_other_vectors_to_the_same_bits(tmp_path, monkeypatch):
    """Begun with 8 lanes, gone on with 4 and no fused multiply-add in hardware, ended with 1."""
    loop, targets = uncertain_pendulum(), ("8 lanes", "no fused multiply-add", "1 lanes")
    for k, name in enumerate(targets, start=1):
        monkeypatch.setattr(compiled, "host_target", lambda name=name: TARGETS[name])
        result = ensemble(loop, 20 * k, 0.1, chunk=20, store=tmp_path / "store")
    monkeypatch.undo()
    xr.testing.assert_identical(result, ensemble(loop, 60, 0.1, chunk=20))


def truncate(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


@pytest.mark.filterwarnings("ignore:Object at:UserWarning")  # of zarr, reading all the same
@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("energy/0", truncate),
        ("energy/0", flip),
        ("count/0", Path.unlink),  # what zarr alone takes for zeros
        ("count/.zarray", Path.unlink),
        (".zattrs", truncate),
        (".zgroup", Path.unlink),
    ],
)
def test_a_damaged_chunk_is_told_of_and_run_again(finished, store, damage, name):
    loop, _, result = finished
    damage(store / "chunks" / "000001" / name)
    before = inodes(store)
    with pytest.warns(UserWarning, match=r"chunks/000001: damaged; its paths are run again"):
        again = run(loop, store=store)
    xr.testing.assert_identical(again, result)
    after = inodes(store)
    assert {k for k in after if after[k] != before[k]} == {"000001"}
    xr.testing.assert_identical(run(loop, store=store), result)


@pytest.mark.parametrize("damage", [truncate, Path.unlink])
def test_a_damaged_root_is_no_store(finished, store, damage):
    damage(store / ".zattrs")
    with pytest.raises(ParameterError, match=r"no store of an ensemble|another experiment"):
        run(finished[0], store=store)


def test_more_paths_reuse_what_is_there(finished, store):
    loop = finished[0]
    before = inodes(store)
    more = run(loop, paths=420, store=store)
    xr.testing.assert_identical(more, run(loop, paths=420))
    after = inodes(store)
    assert {k for k in before if before[k] == after[k]} == {"000000", "000001"}  # whole ones
    assert len(after) == 5


def test_fewer_paths_leave_what_is_there(finished, store):
    loop = finished[0]
    before = inodes(store)
    fewer = run(loop, paths=130, store=store)
    xr.testing.assert_identical(fewer, run(loop, paths=130))
    assert inodes(store) == before


def test_two_processes_do_not_share_a_store(finished, store):
    """The second is refused, and touches nothing that the first is writing."""
    loop, _, result = finished
    unfinished = store / "chunks" / "000007.1.part"
    script = (
        "import json, sys; from ftcfa.study.store import Store; import zarr\n"
        "place = sys.argv[1]; identity = json.loads(zarr.open_group(place).attrs['identity'])\n"
        "with Store(place, identity): print('open', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script, str(store)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdout.readline() == "open\n"
        unfinished.mkdir()
        with pytest.raises(FtcfaError, match="another process is writing to it; wait until"):
            run(loop, store=store)
        assert unfinished.exists()
        read_all(store)  # reading needs nobody's leave
        other.kill()
    xr.testing.assert_identical(run(loop, store=store), result)
    assert not unfinished.exists()


def test_many_that_begin_the_same_store_at_once(tmp_path):
    """One makes it; each then has it or gets the error that another has."""
    outcomes, barrier = [], threading.Barrier(8)

    def begin():
        barrier.wait()
        try:
            with Store(tmp_path / "store", {"a": 1}) as store:
                store.write(0, xr.Dataset({"x": ("path", np.arange(3.0))}))
            outcomes.append("had it")
        except FtcfaError as error:
            outcomes.append(error.got)

    threads = [threading.Thread(target=begin) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(outcomes) == 8
    assert "had it" in outcomes
    assert set(outcomes) <= {"had it", "another process is writing to it"}
    assert [it.name for it in tmp_path.iterdir()] == ["store"]


def test_a_failed_run_leaves_the_store_free(finished, tmp_path):
    """An error within the context gives the lock back."""

    def fail(*_):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        run(finished[0], store=tmp_path / "store", progress=fail)
    xr.testing.assert_identical(run(finished[0], store=tmp_path / "store"), finished[2])


def test_an_edited_urdf_is_another_experiment(tmp_path):
    """The same path, another robot."""
    from ftcfa import FTCF, ClosedLoop, load_arm
    from ftcfa.model.urdf.catalogue import catalogue

    urdf = tmp_path / "arm.urdf"
    text = Path(catalogue()["double_pendulum"].path()).read_text()

    def loop():
        arm = load_arm(str(urdf))
        return ClosedLoop(arm, FTCF(arm), Sinusoid(offset=arm.home))

    urdf.write_text(text)
    run(loop(), store=tmp_path / "store")
    urdf.write_text(text.replace('effort="15"', 'effort="14"'))
    assert urdf.read_text() != text
    simulate(loop(), 0.01)
    with pytest.raises(ParameterError, match=r"another experiment \(they differ in loop\.arm"):
        run(loop(), store=tmp_path / "store")


def test_a_store_is_discarded_and_nothing_else(tmp_path):
    discard(tmp_path / "nothing")
    other = tmp_path / "letters"
    other.mkdir()
    (other / "one.txt").write_text("dear")
    with pytest.raises(ParameterError, match="no store"):
        discard(other)
    assert (other / "one.txt").exists()
