"""Files are written whole or not at all."""

import resource
from contextlib import contextmanager

import pytest

from ftcfa.errors import FtcfaError
from ftcfa.files import make_folder, write_whole

ROOM = 1000
"""Size up to which a file may grow while the disk is full [bytes]."""


@contextmanager
def full_disk():
    """No file may grow beyond ROOM: the nearest thing to a full disk without one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_write_and_overwrite(tmp_path) -> None:
    file = tmp_path / "table.json"
    write_whole(file, b"first")
    write_whole(file, b"second")
    assert file.read_bytes() == b"second"
    assert list(tmp_path.iterdir()) == [file]


def test_a_full_disk_leaves_the_old_file(tmp_path) -> None:
    file = tmp_path / "figure.png"
    write_whole(file, b"old")
    with full_disk(), pytest.raises(FtcfaError, match=r"figure\.png: cannot be written \(.+\)"):
        write_whole(file, bytes(10 * ROOM))
    assert file.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [file]


def test_an_interrupt_leaves_nothing(tmp_path, monkeypatch) -> None:
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("pathlib.Path.replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "figure.png", b"new")
    assert not list(tmp_path.iterdir())


def test_folder_is_made_with_its_parents(tmp_path) -> None:
    folder = tmp_path / "a" / "b"
    make_folder(folder)
    make_folder(folder)
    assert folder.is_dir()
    assert not list(folder.iterdir())


@pytest.mark.parametrize("below", ["", "out", "out/deep"])
def test_folder_on_or_below_a_file(tmp_path, below) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(FtcfaError, match=r"cannot be written \(.+\); choose another folder"):
        make_folder(tmp_path / "file" / below)
    assert (tmp_path / "file").read_text() == "kept"


def test_folder_that_cannot_be_written(tmp_path, monkeypatch) -> None:
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.write_bytes", refuse)
    with pytest.raises(FtcfaError, match="permission denied"):
        make_folder(tmp_path)
