"""How does the paper's law fare against its rivals, and what is each of its ingredients worth?

    python scripts/compare_laws.py [--quick] [--paths N] [--out FOLDER]

All laws under the same noise, on the double pendulum of the paper (10,000 paths) and on Panda on
the floor of a truck, every path with a robot of its own whose inertias are known to some 20 %
(1,000 paths). Their defaults follow one rule, that of `ftcfa.control.laws`; period, torque
limits and the nominal robot are the same for all.
"""

import argparse
from pathlib import Path

from rich.console import Console

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ShapedNoise,
    Sinusoid,
    Uncertainty,
    Vibration,
    load_arm,
)
from ftcfa.files import make_folder, write_whole
from ftcfa.report.comparison import comparison_files, print_comparison
from ftcfa.study.comparison import compare
from ftcfa.study.reproduction import FINITE_TIME, closed_loop
from ftcfa.study.variants import ablations, conditions, rivals

FIGURES = Path(__file__).parent / "figures"
TRUCK = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]
PATHS = {"pendulum": 10_000, "panda": 1_000}
DURATION = {"pendulum": 10.0, "panda": 5.0}


def pendulum():
    """The paper's study, the plant repaired."""
    return closed_loop(FINITE_TIME)


def panda():
    """Panda on a truck's floor, home + 0.3 sin t; its inertias are known to some 20 %."""
    arm = load_arm("panda")
    return ClosedLoop(
        arm,
        FTCF(arm, compensation="bias"),
        Sinusoid(amplitude=0.3, angular_frequency=1.0, offset=arm.home),
        Vibration(BaseAcceleration("xyz"), ShapedNoise(TRUCK)),
        substeps=4,
        uncertainty=Uncertainty(mass=0.2, centre=0.01, shape=0.1),
    )


LOOPS = {"pendulum": (pendulum, "Double pendulum"), "panda": (panda, "Panda on a truck's floor")}


def main():
    """Print the tables, draw the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a look: 16 paths of 0.5 s")
    parser.add_argument("--paths", type=int, help="of each law, for 10,000 and 1,000")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the figures")
    given = parser.parse_args()
    make_folder(given.out)
    console = Console(highlight=False)
    for name, (make, title) in LOOPS.items():
        paths = 16 if given.quick else given.paths or PATHS[name]
        duration = 0.5 if given.quick else DURATION[name]
        loop = make()
        for kind, loops in (
            ("rivals", rivals(loop)),
            ("ablations", ablations(loop)),
            ("conditions", conditions(loop)),
        ):
            console.print(f"\n{title}: {kind}\n")
            found = compare(loops, paths, duration)
            print_comparison(found, console)
            if kind == "rivals":
                image = comparison_files(found, title)["comparison.png"]
                write_whole(given.out / f"rivals-{name}.png", image)


if __name__ == "__main__":
    main()
