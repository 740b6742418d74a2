"""What do sensors, actuators, an accelerometer and observers cost?"""

from dataclasses import replace

from contenders import compiled
from rich.console import Console
from tables import show, target
from timing import Effort, Record, measured

from ftcfa import (
    FTCF,
    Accelerometer,
    Actuators,
    BackwardDifference,
    BaseAcceleration,
    ClosedLoop,
    Hardware,
    Kalman,
    Levant,
    ModelObserver,
    Sensors,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
)

MOST = 1.6
"""Largest time with sensors, actuators and accelerometer, over that of the ideal loop."""
SENSORS = Sensors(
    1e-5, noise=1e-5, offset=1e-3, velocity_noise=1e-3, latency=1e-3, dropped=0.01
)  # every block on
ACTUATORS = Actuators(1000.0, 0.01, delay=1e-3, bandwidth=200.0, ripple=0.05)
ACCELEROMETER = Accelerometer(
    noise_density=1e-3, bias=0.01, range=160.0, bandwidth=200.0, delay=1e-3
)  # three axes: the base does not turn


def measure(effort: Effort) -> Record:
    """The record of Panda on a shaken base, with one block of hardware after another.

    The period is that of an integration step, so that every block runs at every step.
    """
    arm = load_arm("panda")
    base = Vibration(BaseAcceleration(), WhiteNoise(0.1))
    ideal = ClosedLoop(arm, FTCF(arm, compensation="bias"), Sinusoid(offset=arm.home), base)
    blocks = {
        "ideal": None,
        "sensors": Hardware(SENSORS),
        "actuators": Hardware(actuators=ACTUATORS),
        "accelerometer": Hardware(accelerometer=ACCELEROMETER),
        "all three": Hardware(SENSORS, ACTUATORS, ACCELEROMETER),
        "fr3": "fr3",
        **{
            name: Hardware(Sensors(1e-5, velocity=estimator))
            for name, estimator in {
                "backward difference": BackwardDifference(50.0),
                "Levant": Levant(),
                "model observer": ModelObserver(arm),
                "Kalman": Kalman(arm),
            }.items()
        },
    }
    contenders = [
        compiled(replace(ideal, hardware=hardware), effort.threads) for hardware in blocks.values()
    ]
    for name, contender in zip(blocks, contenders, strict=True):
        contender.name = name
    rows = measured(contenders, effort)
    own = rows[0]["us"]
    ratios = {row["contender"]: row["us"] / own for row in rows}
    targets = [target("all three / ideal (Panda)", ratios["all three"], "<=", MOST)]
    return {"rows": rows, "ratios": ratios, "targets": targets}


def print_tables(hardware: Record, console: Console) -> None:
    """Print the times and their ratios to the ideal loop."""
    ratios = hardware["ratios"]
    show(
        console,
        f"Panda with hardware, at {hardware['rows'][0]['threads']} threads",
        ["hardware", "us per path-step", "over ideal"],
        ([r["contender"], r["us"], ratios[r["contender"]]] for r in hardware["rows"]),
    )
