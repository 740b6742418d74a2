"""Does every machine give the same bits?

    python scripts/machines.py [--quick] [--out FOLDER]

Six loops run for 10 s on this machine as it is, with vectors of 1 to 16 lanes, without AVX-512 or
fused multiply-adds, as three other processors, with NumPy and OpenBLAS on other instructions, and
on an emulated aarch64 (scripts/aarch64.sh; five minutes, or why it cannot be). A loop has
one hash, over all numbers of its Dataset. Then a store is begun with 8 lanes, killed, gone on with
by 4 lanes, and finished on aarch64. Writes machines.json; the exit status is 1 if two hashes of a
loop differ.
"""

import argparse
import hashlib
import json
import os
import runpy
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from unittest.mock import patch

import numpy as np
import xarray as xr

import ftcfa
from ftcfa.engine import compiled
from ftcfa.files import write_whole

SCRIPTS = Path(__file__).parent
PLAYED = runpy.run_path(str(SCRIPTS.parent / "tests/engine/targets.py"))
TARGETS, ELSEWHERE = PLAYED["TARGETS"], PLAYED["ELSEWHERE"]
PATHS, SEED, CHUNK, STORED = 8, 7, 10, 40
AS_IT_IS = "8 lanes"
EMULATED = "aarch64, emulated"
SKIPPED = 77
"""Exit status of scripts/aarch64.sh where the emulator cannot be had."""


def loops() -> dict[str, ftcfa.ClosedLoop]:
    """The loops by name."""
    pendulum, panda = ftcfa.load_arm("double_pendulum"), ftcfa.load_arm("panda")
    start = {"q0": (-0.1, 0.25), "v0": (-0.3, 0.45)}
    paper = ftcfa.Sinusoid((1.5, 1.0), (1.0, 2.0))
    white = ftcfa.Vibration(ftcfa.BaseAcceleration("xz"), ftcfa.WhiteNoise(0.1))
    truck = ftcfa.ShapedNoise.from_psd("mil_std_810g_highway_truck_vertical")
    shaped = ftcfa.Vibration(ftcfa.BaseAcceleration("z"), truck)
    spread = ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1, payload=(0.0, 2.0))

    def swinging(vibration: ftcfa.Vibration, uncertainty: ftcfa.Uncertainty | None = None):
        law = ftcfa.FTCF(panda, compensation="bias")
        reference = ftcfa.Sinusoid(0.3, offset=panda.home)
        return ftcfa.ClosedLoop(
            panda, law, reference, vibration, substeps=4, uncertainty=uncertainty
        )

    return {
        "pendulum": ftcfa.ClosedLoop(pendulum, ftcfa.FTCF(pendulum), paper, white, **start),
        "pendulum, kappa = 0.3": ftcfa.ClosedLoop(
            pendulum, ftcfa.FTCF(pendulum, ftcfa.Gains(kappa=0.3)), paper, white, **start
        ),
        "pendulum, super-twisting": ftcfa.ClosedLoop(
            pendulum, ftcfa.SuperTwisting(pendulum), paper, white, **start
        ),
        "Panda": swinging(white),
        "Panda, uncertain": swinging(white, spread),
        "Panda, shaped noise": swinging(shaped),
    }


def digest(dataset: xr.Dataset) -> str:
    """The first 16 digits of a SHA-256 over the numbers of a Dataset, variable by variable."""
    numbers = [dataset[name].values for name in sorted(map(str, dataset.variables))]
    content = b"".join(np.ascontiguousarray(a).tobytes() for a in numbers if a.dtype.kind in "fiub")
    return hashlib.sha256(content).hexdigest()[:16]


def hashes(seconds: float) -> dict[str, str]:
    """The hash of each loop."""
    runs = {
        name: ftcfa.simulate_paths(loop, PATHS, seconds, seed=SEED, record_every=10)
        for name, loop in loops().items()
    }
    return {name: digest(dataset) for name, dataset in runs.items()}


def stored(folder: str | None) -> dict[str, str]:
    """The hash of an ensemble of uncertain Pandas, gone on with where its store ends."""
    loop = loops()["Panda, uncertain"]
    result = ftcfa.ensemble(loop, STORED, 0.5, seed=SEED, chunk=CHUNK, store=folder)
    return {"store": digest(result)}


def here(machine: str, job: str) -> dict[str, str]:
    """What a job gives with the vectors of a machine."""
    kind, _, of = job.partition("=")
    with patch.object(compiled, "host_target", lambda: TARGETS[machine]):
        return hashes(float(of)) if kind == "hashes" else stored(of or None)


def command(machine: str, job: str) -> list[str | Path]:
    """The command that runs a job on a machine."""
    python = [SCRIPTS / "aarch64.sh"] if machine == EMULATED else [sys.executable]
    target = machine if machine in TARGETS else AS_IT_IS
    return [*python, Path(__file__).resolve(), "--machine", target, "--job", job]


def on(machine: str, job: str) -> dict[str, str]:
    """What a job gives on a machine; {} where the machine cannot be had."""
    environment = {**os.environ, **ELSEWHERE.get(machine, {})}
    run = subprocess.run(command(machine, job), env=environment, capture_output=True, text=True)
    if run.returncode == SKIPPED:
        print(f"{machine}: {run.stderr.strip().splitlines()[-1]}", flush=True)
        return {}
    if run.returncode:
        sys.exit(f"{machine}: {run.stderr}")
    found: dict[str, str] = json.loads(run.stdout.splitlines()[-1])
    print(f"{machine:26}", *found.values(), flush=True)
    return found


def interrupted(folder: Path) -> dict[str, str]:
    """Begin a store with 8 lanes, go on with 4, finish it on aarch64; its hash."""
    for chunks, machine in ((1, AS_IT_IS), (2, "4 lanes")):
        run = subprocess.Popen(command(machine, f"store={folder}"))
        while len(list(folder.glob("chunks/00*"))) < chunks and run.poll() is None:
            time.sleep(0.002)
        run.send_signal(signal.SIGKILL)
        run.wait()
        finished = len(list(folder.glob("chunks/00*")))
        print(f"killed on {machine} after {finished} of {STORED // CHUNK} chunks", flush=True)
    return on(EMULATED, f"store={folder}")


def main() -> None:
    """Print the hashes and write their record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="0.2 s instead of 10 s")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of the record")
    parser.add_argument("--machine", help=argparse.SUPPRESS)
    parser.add_argument("--job", help=argparse.SUPPRESS)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.job:
        print(json.dumps(here(options.machine, options.job)))
        return
    options.out.mkdir(parents=True, exist_ok=True)
    seconds = 0.2 if options.quick else 10.0
    each = {name: on(name, f"hashes={seconds}") for name in (*TARGETS, *ELSEWHERE, EMULATED)}
    with tempfile.TemporaryDirectory() as folder:
        stores = [on(AS_IT_IS, "store"), interrupted(Path(folder) / "store")]
    each = {name: found for name, found in each.items() if found}
    stores = [found for found in stores if found]  # one if nothing could finish the other
    same = all(found == group[0] for group in ([*each.values()], stores) for found in group)
    record = {"seconds": seconds, "machines": each, "stores": stores, "same": same}
    write_whole(options.out / "machines.json", json.dumps(record, indent=1).encode())
    print("one hash a loop" if same else "the machines differ")
    sys.exit(not same)


if __name__ == "__main__":
    main()
