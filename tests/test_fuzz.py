"""Damaged files of every kind: each loads, or is refused by an error of ours; nothing else.

Each case is made by a seed, so that a failure can be made again alone: `case(kind, seed)`. By
default a few hundred of each kind run; ``-m slow`` runs ``MANY``.
"""

import io
import random
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from ftcfa import FtcfaError, load_arm, load_experiment
from ftcfa.loop.references import Table
from ftcfa.vibration.records.record import read_record
from ftcfa.vibration.spectra.standards import read_table

FEW, MANY, PART = 400, 100_000, 10_000
"""Cases of each kind by default and when slow, and those of one slow test."""
ODD = (
    b"", b"0", b"-1", b"nan", b"inf", b"1e400", b"1e-400", b"1_0", b"0x10", b"9" * 5000, b"\x00",
    b"\xff", b"\xef\xbb\xbf", b"\n", b"\r", b"\t", b",", b";", b'"', b"'", b"<", b">", b"&", b"[",
    b"]", b"{", b"}", b"=", b"#", b"$", b"${1}", b"%", b"true", b"home", b"~nobody", b"../..",
    b"https://x.y/z", b"file:///etc/passwd", b"2025-01-01T00:00:00", b"99999999999999999999",
    b"\xe2\x80\xae", b"[[" * 500, b"<a>" * 500, "\uff11".encode(), b"type", b"robot", b"10**9",
)  # fmt: skip
"""What damaged and hostile files have in odd places."""

URDF = b"""<?xml version="1.0"?>
<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.1 0 0.2" rpy="0 0 0"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1 0 0.2"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0 0 0.5"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="10" velocity="2"/>
<dynamics damping="0.1" friction="0.2"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="10" velocity="2"/>
<mimic joint="shoulder" multiplier="2" offset="0.1"/></joint>
<transmission name="t"><joint name="shoulder"/><actuator name="m">
<drake:rotor_inertia value="1e-4"/><drake:gear_ratio value="50"/></actuator></transmission></robot>
"""
CSV = b"time [s],x [g],y [m/s^2]\n" + b"".join(b"%.2f,%d,0.5\n" % (k / 100, k) for k in range(12))
DATES = b"when;x [mg]\n" + b"".join(
    b"2025-01-02T10:00:00.%02d0Z;1,%d\n" % (k, k) for k in range(12)
)
MOTION = b"time,shoulder,elbow\n0,0.1,0.2\n1,0.2,0.3\n2,0.1,0.2\n"
TABLE = b"""[hall]
points = [[10, 0.015], [40, 0.015], [40, 0.03], [500, "-3 dB/octave"]]
unit = "g^2/Hz"
source = "a document"
nominal_g_rms = 1.87
"""
EXPERIMENT = b"""duration = 1.0
paths = 10
period = 0.001
substeps = 2
q0 = "home"
arm = { robot = "arm.urdf", gravity = 9.81, effort_limit = { shoulder = 9 } }
controller = { type = "FTCF", compensation = "bias", gains = { c1 = 7.5, kappa = 0.5 } }
reference = { type = "Sinusoid", amplitude = [0.1], angular_frequency = 0.5 }
[vibration]
input = { type = "BaseAcceleration", axes = "z" }
excitation = { type = "ShapedNoise", axes = [{ points = [[10, 0.001], [40, 0.001]] }] }
[specification]
error = 0.1
within = 0.5
"""


class Kind(NamedTuple):
    """A kind of file: its name, a good content, and the reader."""

    name: str
    content: bytes
    read: Callable[[Path], object]


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def npz(compression):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        members = {
            "time": np.arange(9.0) / 10,
            "acceleration": np.ones((9, 2)),
            "unit": np.array("g"),
        }
        for name, array in members.items():
            archive.writestr(f"{name}.npy", npy(array))
    return buffer.getvalue()


RISING = np.arange(9.0)[:, None] * np.ones(3)
KINDS = {
    "urdf": Kind("arm.urdf", URDF, load_arm),
    "csv": Kind("run.csv", CSV, read_record),
    "dates": Kind("run.txt", DATES, read_record),
    "npy": Kind(
        "run.npy", npy(np.ones((9, 3)) * np.arange(9.0)[:, None]), lambda f: read_record(f, "g")
    ),
    "npz": Kind("run.npz", npz(zipfile.ZIP_STORED), read_record),
    "deflated npz": Kind("run.npz", npz(zipfile.ZIP_DEFLATED), read_record),
    "motion": Kind("motion.csv", MOTION, Table.from_file),
    "table": Kind("site.toml", TABLE, read_table),
    "experiment": Kind("e.toml", EXPERIMENT, load_experiment),
}


def damaged(content: bytes, rng: random.Random) -> bytes:
    """A content with some bytes changed, taken out, put in, repeated or cut off."""
    text = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        a = rng.randrange(len(text) + 1)
        b = min(len(text), a + rng.choice((0, 1, 1, 2, 5, 20, 100)))
        match rng.randrange(7):
            case 0:
                text[a:b] = bytes(rng.randrange(256) for _ in range(b - a))
            case 1:
                del text[a:b]
            case 2:
                text[a:a] = rng.choice(ODD)
            case 3:
                text[a:b] = rng.choice(ODD)
            case 4:
                text[a:a] = text[a:b] * rng.choice((1, 2, 50))
            case 5:
                words = [m for m in bytes(text).replace(b'"', b" ").split() if m]
                if words:
                    word = rng.choice(words)
                    at = bytes(text).find(word)
                    text[at : at + len(word)] = rng.choice(ODD)
            case 6 if rng.random() < 0.3:
                del text[a:]
    return bytes(text)


def case(kind: str, seed: int) -> bytes:
    """The content of one case."""
    return damaged(KINDS[kind].content, random.Random(f"{kind} {seed}"))


def failures(kind: str, seeds: range, folder: Path) -> list[str]:
    """The cases of a kind that end in something else than a result or an error of ours."""
    name, _, read = KINDS[kind]
    (folder / "arm.urdf").write_bytes(URDF)
    found = []
    for seed in seeds:
        file = folder / name
        file.write_bytes(case(kind, seed))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read(file)
        except FtcfaError as error:
            if not str(error) or any(ord(x) < 32 and x != "\n" for x in str(error)):
                found.append(f"{kind} {seed}: a message with control characters")
        except Exception as error:
            found.append(f"{kind} {seed}: {type(error).__name__}: {str(error)[:100]}")
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_the_undamaged_file_loads(kind, tmp_path):
    name, content, read = KINDS[kind]
    (tmp_path / "arm.urdf").write_bytes(URDF)
    (tmp_path / name).write_bytes(content)
    assert read(tmp_path / name) is not None


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_loads_or_is_refused(kind, tmp_path):
    assert failures(kind, range(FEW), tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("part", range(MANY // PART))
@pytest.mark.parametrize("kind", KINDS)
def test_many_damaged_files_load_or_are_refused(kind, part, tmp_path):
    assert failures(kind, range(part * PART, (part + 1) * PART), tmp_path) == []
