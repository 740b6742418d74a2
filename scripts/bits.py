"""Are the numbers of two versions, or of two machines, the same to the bit?

    python scripts/bits.py

One hash for each loop. A change that should not touch the numbers prints the same lines before and
after it. A hash covers the values of all variables of a Dataset; their names do not matter.
"""

import hashlib
import json
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import ftcfa

SEED = 7
TRUCK = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]


def digest(arrays):
    """The first 16 digits of a SHA-256 over arrays of numbers, in any order."""
    each = sorted(hashlib.sha256(np.ascontiguousarray(a).tobytes()).hexdigest() for a in arrays)
    return hashlib.sha256("".join(each).encode()).hexdigest()[:16]


def of_dataset(dataset):
    """The hash of a Dataset's numbers."""
    values = [dataset[name].values for name in dataset.variables]
    return digest([v for v in values if v.dtype.kind in "fiub"])


def loops():
    """Name and closed loop of every kind of part."""
    base, white = ftcfa.BaseAcceleration, ftcfa.WhiteNoise(0.1)
    pendulum, panda = ftcfa.load_arm("double_pendulum"), ftcfa.load_arm("panda")
    paper = ftcfa.Sinusoid((1.5, 1.0), (1.0, 2.0))
    start = {"q0": (-0.1, 0.25), "v0": (-0.3, 0.45)}
    shaken = ftcfa.Vibration(base("xz"), white)

    def swings(arm):
        return ftcfa.Sinusoid(0.3, 1.0, 0.0, arm.home)

    for name, law in ftcfa.CONTROLLERS.items():
        yield f"pendulum, {name}", ftcfa.ClosedLoop(pendulum, law(pendulum), paper, shaken, **start)
    law = ftcfa.FTCF(panda, compensation="bias")
    truck = ftcfa.Vibration(base("xyz"), ftcfa.ShapedNoise.from_psd(*TRUCK))
    spread = ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1, friction=0.3, payload=(0.0, 2.0))
    yield (
        "Panda on a truck, uncertain",
        ftcfa.ClosedLoop(panda, law, swings(panda), truck, substeps=4, uncertainty=spread),
    )
    inputs = {
        "frame wrench": (ftcfa.FrameWrench("panda_link7", "xyz", "z"), ftcfa.WhiteNoise(0.1)),
        "joint torque": (ftcfa.JointTorque(), ftcfa.WhiteNoise(0.1)),
        "random phase": (base("z"), ftcfa.RandomPhase([TRUCK[2]])),
        "sine on random": (base("z"), ftcfa.ShapedNoise([TRUCK[2]]) + ftcfa.Harmonic(5.0, 12.0)),
        "sweep": (base("x"), ftcfa.SineSweep(5.0, 10, 50, 2.0)),
        "turning base": (ftcfa.BaseMotion("", "z"), ftcfa.Harmonic(2.0, 3.0)),
        "road": (base("z"), ftcfa.ShapedNoise([ftcfa.Road("C", 25.0, ftcfa.TRUCK)])),
        "record": (base("z"), ftcfa.RecordedAcceleration(record())),
    }
    for name, (shaking, excitation) in inputs.items():
        vibration = ftcfa.Vibration(shaking, excitation)
        yield f"Panda, {name}", ftcfa.ClosedLoop(panda, law, swings(panda), vibration, substeps=4)
    for name in ("ur5", "kinova", "xarm7", "baxter"):
        arm = ftcfa.load_arm(name, mounting="ceiling")
        law = ftcfa.FTCF(arm, compensation="gravity")
        yield name, ftcfa.ClosedLoop(arm, law, swings(arm), ftcfa.Vibration(base("xyz"), white))


def record():
    """A record of a floor, 2 s at 1 kHz."""
    values = np.random.default_rng(SEED).standard_normal((2000, 1))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "floor.csv"
        rows = [f"{i / 1000:.3f},{v[0]:.17g}" for i, v in enumerate(values)]
        file.write_text("\n".join(["time [s],z [m/s^2]", *rows]) + "\n")
        return ftcfa.read_record(file)


def study():
    """The hash of the numbers of `ftcfa reproduce --quick`."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ftcfa", "reproduce", "--quick", "--out", folder]
        subprocess.run(command, check=True, capture_output=True)
        return digest([np.array(numbers(json.loads((Path(folder) / "summary.json").read_text())))])


def numbers(data):
    """All numbers with a fraction in JSON data, in order."""
    if isinstance(data, dict | list):
        inner = data.values() if isinstance(data, dict) else data
        return [number for value in inner for number in numbers(value)]
    return [data] if isinstance(data, float) else []


def main():
    """Print the hashes."""
    warnings.simplefilter("ignore")
    for name, loop in loops():
        paths = ftcfa.simulate_paths(loop, 9, 0.6, seed=SEED)
        many = ftcfa.ensemble(loop, 9, 0.6, seed=SEED, chunk=4)
        alone = ftcfa.simulate(loop, 0.4, seed=SEED, engine="interpreted")
        print(f"{name:48} {of_dataset(paths)} {of_dataset(many)} {of_dataset(alone)}", flush=True)
    print(f"{'ftcfa reproduce --quick':48} {study()}")


if __name__ == "__main__":
    main()
