"""How well does FTCF hold each arm of the catalogue, with the paper's gains?

    python scripts/all_arms.py [--out FOLDER] [--quick]

Every arm follows home + 0.3 sin t (prismatic joints: a hundredth of the travel) under its nominal
bias compensation, on a base that white noise of 0.1 (psd) shakes. The script takes a minute; it
prints a table and writes all-arms.json.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.loop.bounds import is_prismatic
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.report.terminal import print_line, print_table

PATHS, DURATION = 32, 10.0
SWING, STROKE = 0.3, 0.01
"""Amplitude of revolute joints [rad], and of prismatic ones as a share of their travel."""
STIFF = {"so101": 100.0}
"""Arms that also run with a larger c2 [1/s]."""


def measured(arm: ftcfa.Arm, gains: ftcfa.Gains, paths: int, duration: float) -> dict[str, Any]:
    """Mean over the paths of the late rms error [rad or m], and what became of the paths."""
    swing = np.where(is_prismatic(arm), STROKE * (arm.upper - arm.lower), SWING)
    loop = ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, gains, compensation="bias"),
        ftcfa.Sinusoid(swing, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1)),
    )
    run = ftcfa.ensemble(loop, paths, duration)
    counts = {word: run.attrs[word] for word in ("kept", "lost_track", "broke_a_limit", "diverged")}
    return {
        "rms_error": float(run.late_rms_error.mean()),
        **counts,
        "diagnosis": run.attrs["diagnosis"],
    }


def main() -> None:
    """Run all arms, print the table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the record")
    parser.add_argument("--quick", action="store_true", help="few short paths of two arms: seconds")
    options = parser.parse_args()
    make_folder(options.out)
    paths, duration = (4, 0.5) if options.quick else (PATHS, DURATION)
    names = ["double_pendulum", "panda"] if options.quick else list(catalogue())
    cases = {name: (name, ftcfa.Gains()) for name in names}
    cases |= {f"{name}, c2 = {c2:g}": (name, ftcfa.Gains(c2=c2)) for name, c2 in STIFF.items()}
    record = {
        case: measured(ftcfa.load_arm(name), gains, paths, duration)
        for case, (name, gains) in cases.items()
    }
    console = Console(highlight=False)
    title = f"Late rms error, {paths} paths of {duration:g} s, noise 0.1 (psd)"
    print_line(title, console, "bold")
    rows = [
        [name, f"{row['rms_error']:.4f}", *(str(n) for n in list(row.values())[1:-1])]
        for name, row in record.items()
    ]
    heads = ["arm", "rms error\nrad or m", "kept", "lost\ntrack", "broke\na limit", "diverged"]
    print_table(heads, rows, console, "lr")
    for name, row in record.items():
        if row["diagnosis"]:
            print_line(f"{name}: {row['diagnosis']}", console)
    written = {"paths": paths, "duration": duration, "arms": record}
    write_whole(options.out / "all-arms.json", json.dumps(written, indent=1).encode())


if __name__ == "__main__":
    main()
