"""Which sensor and which motor buy which error?

    python scripts/sensors_and_motors.py [--quick] [--out FOLDER]

Panda and UR10 follow home + 0.3 sin t under FTCF with its bias compensated, on a base that shakes
up and down; their masses, and with them their inertias, are known to 20 %. An accelerometer on the
base feeds its motion forward, with the band that `ftcfa.feed_forward_band` chooses. Shown is what
the shaking does: the rms distance from where the same robot would be on a base at rest, median over
8 robots. Two tables follow: the same on a truck's and a ship's base, by limit and delay; and
Panda as it is known, with 1,000 N m/s, whose accelerometer passes on all it reads. It takes some
twelve minutes and writes sensors-and-motors.png and sensors-and-motors.json.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import ftcfa
from ftcfa.files import make_folder, write_whole
from ftcfa.report.figures import STYLE, rendered

FIGURES = Path(__file__).parent / "figures"
ARMS = ("panda", "ur10")
TRUCK = "mil_std_810g_highway_truck_vertical"
FREQUENCIES = np.geomspace(0.1, 30.0, 12).tolist()
AMPLITUDE = 5.0
"""Of a sine of the base [m/s^2]."""
RATES = {"1,000": 1000.0, "5,000": 5000.0, "20,000": 20_000.0, "no limit": np.inf}
"""Torque rate limits [N m/s]."""
DELAYS = (0.0, 1e-3, 2e-3, 5e-3, 1e-2)
"""Delays of the accelerometer [s]."""
DENSITIES = np.geomspace(1e-4, 1.0, 9).tolist()
"""Noise densities of the accelerometer [m/s^2/sqrt(Hz)]."""
SENSOR = {"delay": 1e-3, "noise_density": 2.2e-4}
"""A low-noise accelerometer, where nothing else is said."""
PATHS, DURATION, LOST, SEA = 8, 3.0, np.pi / 2, (0.2, 0.1, 1.0)
COLOURS = ("#D55E00", "#E69F00", "#56B4E9", "#0072B2", "#000000")


def sea(frequency: float, damping: float, rms: float) -> ftcfa.ShapedNoise:
    """Noise about a frequency [Hz] of some rms acceleration [m/s^2]: an example of a ship."""
    w = 2 * np.pi * frequency
    A = np.array([[0.0, 1.0], [-(w**2), -2 * damping * w]])
    B = np.array([[0.0], [rms * np.sqrt(4 * damping * w)]])
    return ftcfa.ShapedNoise(ftcfa.LinearFilter(A, B, np.array([[0.0, 1.0]])))


BASES = {"truck": (ftcfa.ShapedNoise(TRUCK), 4), "ship": (sea(*SEA), 1)}
"""Excitation and substeps of a base."""


def loop(
    robot: str, excitation: Any, substeps: int, rate: float,
    **sensor: float,
) -> ftcfa.ClosedLoop:  # fmt: skip
    """An arm with a motor and a sensor, without feed-forward."""
    arm = ftcfa.load_arm(robot)
    return ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration("z"), excitation),
        substeps=substeps,
        uncertainty=ftcfa.Uncertainty(mass=0.2),
        hardware=ftcfa.Hardware(
            actuators=ftcfa.Actuators(rate_limit=rate),
            accelerometer=ftcfa.Accelerometer(**{**SENSOR, **sensor}),
        ),
    )


def displacement(it: ftcfa.ClosedLoop, duration: float) -> float:
    """Median over the paths of the rms of |q - q on a base at rest|; infinite if half are lost.

    The same robots on a base at rest run beside the others, with a level of zero.
    """
    level = np.repeat([1.0, 0.0], PATHS)
    paths = [*range(PATHS), *range(PATHS)]
    run = ftcfa.simulate_paths(it, paths, duration, vary={"vibration.level": level}, record_every=5)
    late = run.sel(time=slice(min(1.0, duration / 2), None))
    shaken, still = late.q.values[:PATHS], late.q.values[PATHS:]
    rms = np.sqrt(np.mean(np.sum((shaken - still) ** 2, axis=2), axis=1))
    lost = ~(late.ote.max("time").values[:PATHS] < LOST)
    return float(np.median(np.where(lost, np.inf, rms)))


def helped(it: ftcfa.ClosedLoop, duration: float, without: float) -> float:
    """The displacement with the feed-forward that the rule chooses."""
    band = ftcfa.feed_forward_band(it).band
    if band is None:
        return without
    law = ftcfa.FeedForward(it.controller.nominal, it.controller, band)
    return displacement(replace(it, controller=law), duration)


def both(it: ftcfa.ClosedLoop, duration: float) -> dict[str, float]:
    """Displacements without and with feed-forward [rad]."""
    without = displacement(it, duration)
    return {"without": without, "with": helped(it, duration, without)}


def measure(robot: str, quick: bool) -> dict[str, Any]:
    """The record of an arm: over the frequency of a sine, by limit and by delay; and by noise."""
    frequencies = FREQUENCIES[::6] if quick else FREQUENCIES

    def lasting(f: float) -> float:
        return 0.2 if quick else max(DURATION, 1.0 + 1.0 / f)

    def sine(f: float, rate: float, **sensor: float) -> ftcfa.ClosedLoop:
        return loop(robot, ftcfa.Harmonic(AMPLITUDE, f), 1, rate, **sensor)

    rates = {
        name: [both(sine(f, rate), lasting(f)) for f in frequencies]
        for name, rate in list(RATES.items())[: 1 if quick else None]
    }
    free = [cell["without"] for cell in list(rates.values())[-1]]
    delays = {
        f"{1e3 * d:g}": [
            {"without": error, "with": helped(sine(f, np.inf, delay=d), lasting(f), error)}
            for f, error in zip(frequencies, free, strict=True)
        ]
        for d in DELAYS[: 1 if quick else None]
    }
    noise = {
        base: [
            both(
                loop(robot, excitation, substeps, np.inf, noise_density=density),
                lasting_base(base, quick),
            )
            for density in (DENSITIES[::8] if quick else DENSITIES)
        ]
        for base, (excitation, substeps) in BASES.items()
    }
    bases = {
        base: {
            "rates": {
                name: both(loop(robot, excitation, substeps, rate), lasting_base(base, quick))
                for name, rate in list(RATES.items())[: 1 if quick else None]
            },
            "delays": {
                f"{1e3 * d:g}": both(
                    loop(robot, excitation, substeps, np.inf, delay=d), lasting_base(base, quick)
                )
                for d in DELAYS[: 1 if quick else None]
            },
        }
        for base, (excitation, substeps) in BASES.items()
    }
    return {
        "frequencies": frequencies, "rates": rates, "delays": delays, "noise": noise, "bases": bases
    }  # fmt: skip


def lasting_base(base: str, quick: bool) -> float:
    """Duration of a path on a base [s]."""
    return 0.2 if quick else (DURATION if base == "truck" else 10.0)


def measure_whole_band(quick: bool) -> dict[str, list[float]]:
    """Panda at 1,000 N m/s with a whole reading fed forward: rms error [rad] for each base.

    Without feed-forward, with a reading that is 1 ms late, and one that is 10 ms late; the robot is
    known, and the base moves along one or three axes.
    """
    arm, truck = ftcfa.load_arm("panda"), ftcfa.ShapedNoise(TRUCK)
    bases: dict[str, tuple[str, Any, int]] = {
        f"{a:g} m/s² at {f:g} Hz, {axes}": (axes, ftcfa.Harmonic(a, f), 1)
        for a, f in ((2.0, 0.2), (2.0, 1.0), (5.0, 5.0), (5.0, 10.0))
        for axes in ("x", "z", "xyz")
    }
    bases["truck, z"] = "z", truck, 4
    found = {}
    for name, (axes, excitation, substeps) in list(bases.items())[: 1 if quick else None]:
        law = ftcfa.FTCF(arm, compensation="bias")
        motors = ftcfa.Actuators(rate_limit=1000.0)
        without = ftcfa.ClosedLoop(
            arm,
            law,
            ftcfa.Sinusoid(0.3, offset=arm.home),
            ftcfa.Vibration(ftcfa.BaseAcceleration(axes), excitation),
            substeps=substeps,
            hardware=ftcfa.Hardware(actuators=motors),
        )
        loops = [without] + [
            replace(
                without,
                controller=ftcfa.FeedForward(arm, law),
                hardware=ftcfa.Hardware(
                    actuators=motors, accelerometer=ftcfa.Accelerometer(delay=delay)
                ),
            )
            for delay in (1e-3, 1e-2)
        ]
        found[name] = [error(it, 0.2 if quick else 2 * DURATION) for it in loops]
    return found


def error(it: ftcfa.ClosedLoop, duration: float) -> float:
    """Rms of |q - q_d| in the second half of a path; infinite if the arm is lost."""
    late = ftcfa.simulate(it, duration).ote.sel(time=slice(duration / 2, None)).values
    return float(np.sqrt(np.mean(late**2))) if late.max() < LOST else np.inf


@mpl.rc_context(STYLE)
def figure(record: dict[str, Any]) -> Figure:
    """A row for each arm: by the limit of the motors, by the delay and by the noise of the sensor.

    Dashed: without feed-forward.
    """
    drawn = Figure(figsize=(10.0, 3.1 * len(record)), layout="constrained")
    axes = drawn.subplots(len(record), 3, squeeze=False, sharey="row")
    for row, (robot, found) in zip(axes, record.items(), strict=True):
        f = found["frequencies"]
        for ax, group, unit in ((row[0], "rates", "N m/s"), (row[1], "delays", "ms")):
            for colour, (name, cells) in zip(COLOURS, found[group].items(), strict=False):
                label = name if name == "no limit" else f"{name} {unit}"
                if not any(np.isfinite(cell["with"]) for cell in cells):
                    label += ": lost"
                ax.loglog(f, _mrad(cells, "with"), color=colour, lw=1.6, label=label)
                if group == "rates":
                    ax.loglog(f, _mrad(cells, "without"), color=colour, lw=1.0, ls="--")
        row[1].loglog(f, _mrad(cells, "without"), color="#777777", lw=1.0, ls="--", label="without")
        for colour, (base, cells) in zip(COLOURS[::3], found["noise"].items(), strict=False):
            densities = DENSITIES[: len(cells)]
            row[2].loglog(densities, _mrad(cells, "with"), color=colour, lw=1.6, label=base)
            row[2].loglog(densities, _mrad(cells, "without"), color=colour, lw=1.0, ls="--")
        row[0].set_ylabel(f"{robot}: rms displacement [mrad]")
        for ax in row:
            ax.legend(frameon=False, fontsize=7)
    for ax, title in zip(
        axes[0],
        ("torque rate limit, delay 1 ms", "delay, no rate limit", "noise, no rate limit"),
        strict=True,
    ):
        ax.set_title(title, fontsize=9)
    for ax in axes[-1, :2]:
        ax.set_xlabel(f"frequency of the base, {AMPLITUDE:g} m/s² [Hz]")
    axes[-1, 2].set_xlabel("noise density [m/s²/√Hz]")
    return drawn


def _mrad(cells: list[dict[str, float]], which: str) -> list[float]:
    return [1e3 * cell[which] if np.isfinite(cell[which]) else np.nan for cell in cells]


def main() -> None:
    """Measure, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few points, short paths: seconds")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder for figure and record")
    options = parser.parse_args()
    make_folder(options.out)
    arms = {robot: measure(robot, options.quick) for robot in ARMS}
    write_whole(options.out / "sensors-and-motors.png", rendered(figure(arms))["png"])
    record = {"arms": arms, "whole band": measure_whole_band(options.quick)}
    text = json.dumps(record, indent=1).replace("Infinity", "null")
    write_whole(options.out / "sensors-and-motors.json", text.encode())
    print(f"sensors-and-motors.png and .json in {options.out}")


if __name__ == "__main__":
    main()
