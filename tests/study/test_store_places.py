"""Chunks that were exchanged, copied, damaged or deleted: never averaged in silence."""

import json
import shutil

import numpy as np
import pytest
import zarr

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    FtcfaError,
    ParameterError,
    Sinusoid,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
)
from ftcfa.study.store import Store

CHUNK, COUNT = 3, 4


@pytest.fixture(scope="module")
def loop():
    arm = load_arm("double_pendulum")
    noise = Vibration(BaseAcceleration(), WhiteNoise(0.1))
    return ClosedLoop(arm, FTCF(arm), Sinusoid([0.3, 0.2]), vibration=noise)


def run(loop, store):
    return ensemble(loop, CHUNK * COUNT, 0.05, chunk=CHUNK, store=store)


@pytest.fixture(scope="module")
def whole(loop, tmp_path_factory):
    store = tmp_path_factory.mktemp("whole") / "store.zarr"
    return store, run(loop, store)


@pytest.fixture
def copy(whole, tmp_path):
    store, dataset = whole
    return shutil.copytree(store, tmp_path / "store.zarr"), dataset


def places(store):
    return sorted(place for place in (store / "chunks").iterdir() if place.is_dir())


def exchanged(store):
    first, second, *_ = places(store)
    first.rename(store / "x")
    second.rename(first)
    (store / "x").rename(second)
    return 2


def copied(store):
    first, second, *_ = places(store)
    shutil.rmtree(second)
    shutil.copytree(first, second)
    return 1


def other_dimensions(store):
    first = places(store)[0]
    for file in first.rglob(".zattrs"):
        file.write_text(file.read_text().replace('"path"', '"joint"', 1))
    return 1


def cut_off(store):
    file = max(
        (f for f in places(store)[0].rglob("*") if f.is_file()), key=lambda f: f.stat().st_size
    )
    file.write_bytes(file.read_bytes()[:-3])
    return 1


def no_attributes(store):
    (places(store)[0] / ".zattrs").write_text("{")
    return 1


def one_byte(store):
    for file in places(store)[0].rglob("0*"):
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
    return 1


@pytest.mark.parametrize(
    "damage", [exchanged, copied, other_dimensions, cut_off, no_attributes, one_byte]
)
def test_what_is_not_in_its_place_is_run_again(loop, copy, damage):
    store, truth = copy
    damage(store)
    with pytest.warns(UserWarning, match="damaged; its paths are run again"):
        again = run(loop, store)
    for name in truth.data_vars:
        np.testing.assert_array_equal(again[name].values, truth[name].values)


@pytest.mark.parametrize("text", ["{", "[]", '{"identity": "{"}', '{"identity": "[1]"}', "{}"])
def test_a_damaged_identity_is_one_sentence(loop, copy, text):
    store, _ = copy
    (store / ".zattrs").write_text(text)
    with pytest.raises((ParameterError, FtcfaError)) as caught:
        run(loop, store)
    assert "\n" not in str(caught.value)


def test_a_store_deleted_during_the_run_is_said(loop, tmp_path):
    store = tmp_path / "store.zarr"

    def delete(*_):
        shutil.rmtree(store, ignore_errors=True)

    with pytest.raises(FtcfaError, match="was deleted during the run"):
        ensemble(loop, CHUNK * COUNT, 0.05, chunk=CHUNK, store=store, progress=delete)


def test_only_the_chunks_that_are_there_are_read(loop, copy, monkeypatch):
    store, _ = copy
    read = []
    truth = Store.read
    monkeypatch.setattr(Store, "read", lambda self, n: (read.append(n), truth(self, n))[1])
    shutil.rmtree(places(store)[2])
    run(loop, store)
    assert read == [0, 1, 3]


def test_the_store_is_plain_zarr(whole):
    store, _ = whole
    assert json.loads(zarr.open_group(store, mode="r").attrs["identity"])["plan"]["chunk"] == CHUNK
