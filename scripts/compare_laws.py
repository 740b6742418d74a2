"""How good is the paper's law beside its rivals, and how much does each of its parts contribute?

    python scripts/compare_laws.py [--quick] [--paths N] [--out FOLDER]

It prints tables and writes compare-laws.json, rivals-pendulum.png, rivals-panda.png and
rivals-panda-fr3.png.

All laws run under the same noise, on the paper's double pendulum (10,000 paths) and on Panda on
the floor of a truck (1,000 paths, each with a robot of its own whose inertias are known to some
20 %), there with ideal hardware and with the profile fr3. Their default gains follow one rule,
that of `ftcfa.control.laws`; period, torque limits and the nominal robot are the same for all.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

from rich.console import Console

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.report.comparison import comparison_record, print_comparison
from ftcfa.report.comparison_figure import comparison_figure
from ftcfa.report.figures import rendered
from ftcfa.study.comparison import compare
from ftcfa.study.reproduction import Case, closed_loop
from ftcfa.study.variants import ablations, conditions, rivals

FIGURES = Path(__file__).parent / "figures"
TRUCK = [f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical")]
PATHS = {"pendulum": 10_000, "panda": 1_000, "panda-fr3": 1_000}
DURATION = {"pendulum": 10.0, "panda": 5.0, "panda-fr3": 5.0}
STILL = 1e-9
"""Rate of an adaptation that does nothing [1/s]."""
SHOWN = (
    "settling_time", "late_rms_error", "torque_rate", "rms_torque_rate", "rate_limited",
    "saturated", "unsettled", "failed",
)  # fmt: skip
"""Metrics in the record."""


def panda(hardware=None):
    """Panda on a truck's floor, home + 0.3 sin t; its inertias are known to some 20 %."""
    arm = ftcfa.load_arm("panda")
    return ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(amplitude=0.3, angular_frequency=1.0, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration("xyz"), ftcfa.ShapedNoise(TRUCK)),
        substeps=4,
        uncertainty=ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1),
        hardware=hardware,
    )


def pendulum():
    """The paper's pendulum and reference, under the default noise and law."""
    loop = closed_loop(Case(noise="psd"))
    return replace(loop, controller=ftcfa.FTCF(loop.arm))


def tables(loop):
    """The loops of each table, by name; the law as printed stands beside the rivals."""
    printed = replace(loop, controller=ftcfa.printed(loop.controller))
    still = ftcfa.SlotineLi(loop.controller.nominal, adaptation_rate=STILL)
    more = {
        "as given, printed": printed,
        "SlotineLi, adaptation off": replace(loop, controller=still),
    }
    if loop.hardware is not None:
        return {"rivals": rivals(loop) | more}
    return {
        "rivals": rivals(loop) | more,
        "ablations of the law as printed": ablations(printed),
        "conditions": conditions(loop),
    }


LOOPS = {
    "pendulum": (pendulum(), "Double pendulum, white noise 0.1 (psd)"),
    "panda": (panda(), "Panda on a truck's floor"),
    "panda-fr3": (panda("fr3"), "Panda on a truck's floor, hardware fr3"),
}


def summary(record):
    """What README says of a table: mean and quantiles (5, 25, 50, 75, 95 %) of each loop."""
    keys = ("mean", "quantiles", "significant", "median_significant")
    loops = {
        row["loop"]: {name: {key: row["metrics"][name][key] for key in keys} for name in SHOWN}
        for row in record["loops"]
    }
    return {"paths": record["paths"], "duration": record["duration"], "same": record["same"],
            "loops": loops}  # fmt: skip


def main():
    """Print the tables, draw the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="16 paths of 0.5 s")
    parser.add_argument("--paths", type=int, help="number of paths of each law")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for the figures")
    options = parser.parse_args()
    make_folder(options.out)
    console = Console(highlight=False)
    record = {name: {} for name in LOOPS}
    for name, (loop, title) in LOOPS.items():
        paths = 16 if options.quick else options.paths or PATHS[name]
        duration = 0.5 if options.quick else DURATION[name]
        for table, loops in tables(loop).items():
            console.print(f"\n{title}: {table}\n")
            dataset = compare(loops, paths, duration)
            compared = comparison_record(dataset)
            print_comparison(compared, console)
            record[name][table] = summary(compared)
            if table == "rivals":
                image = rendered(comparison_figure(dataset, title))["png"]
                write_whole(options.out / f"rivals-{name}.png", image)
    write_whole(options.out / "compare-laws.json", json.dumps(record, indent=1).encode())


if __name__ == "__main__":
    main()
