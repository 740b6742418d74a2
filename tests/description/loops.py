"""A loop with every kind of part, and a file of an experiment."""

import numpy as np

from ftcfa import (
    FTCF,
    TRUCK,
    Accelerometer,
    Actuators,
    BackwardDifference,
    BaseAcceleration,
    BaseMotion,
    ClosedLoop,
    CommandFilteredBackstepping,
    ComputedTorque,
    Constant,
    ExplicitFilter,
    FeedForward,
    FiniteTimeBackstepping,
    FrameWrench,
    Gains,
    Gyroscope,
    Hardware,
    Harmonic,
    ImplicitFilter,
    JointTorque,
    Kalman,
    Levant,
    LinearFilter,
    MinimumJerk,
    ModelObserver,
    PaperPendulum,
    PaperPendulumInput,
    PDGravity,
    PositionFeedback,
    Predictor,
    ProperFilter,
    RandomPhase,
    RBFNetwork,
    Record,
    RecordedAcceleration,
    Road,
    SecondOrderFilter,
    Sensors,
    ShapedNoise,
    SineSweep,
    Sinusoid,
    SlotineLi,
    Spectrum,
    Stacked,
    Standard,
    StochasticBackstepping,
    Superposition,
    SuperTwisting,
    Table,
    Uncertainty,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
)
from ftcfa.model.urdf.catalogue import robots_folder

DURATION = 0.05
ARM = load_arm("double_pendulum")
URDF = (robots_folder() / "double_pendulum.urdf").read_text()
THIRD = 1.0 / 3.0
"""A float that no short decimal is."""
RNG = np.random.default_rng(7)
RECORD = Record(0.004, RNG.standard_normal((50, 2)), ("x", "z"), ("by hand",))
BAND = Spectrum([5.0, 20.0, 60.0], [0.1, 0.2, 0.05])
COLOUR = LinearFilter([[-3.0, 1.0], [0.0, -THIRD]], [[0.0], [1.0]], [[1.0, 0.0]])


def loop(arm=ARM, *, excitation=None, axes="xz", vibration=None, **changes):
    """A pendulum under the paper's law, shaken."""
    if excitation is not None:
        vibration = Vibration(BaseAcceleration(axes), excitation)
    parts = {"controller": FTCF(arm), "reference": Sinusoid(THIRD, 1.0, 0.0, arm.home)}
    return ClosedLoop(arm, **{**parts, "vibration": vibration, **changes})


def shaped(*axes):
    return loop(excitation=ShapedNoise(axes), axes="x", substeps=4)


LOOPS = {
    "still": lambda: loop(),
    "numbers of a loop": lambda: loop(
        period=THIRD / 100, substeps=3, integrator="semi-implicit", q0=[0.1, THIRD], v0=[0.2, 1e-17]
    ),
    "keywords of load_arm": lambda: loop(
        load_arm(
            "panda",
            lock={"panda_joint7": THIRD, "panda_finger_joint1": 0.02},
            gravity=[0.0, THIRD, -9.0],
            effort_limit={"panda_joint1": 50 * THIRD},
            mounting="wall",
        )
    ),
    "gains, filter, network": lambda: loop(
        controller=FTCF(
            ARM, Gains(c1=THIRD), ExplicitFilter(700.0, 170.0), "gravity", RBFNetwork(7, THIRD)
        )
    ),
    "other filter": lambda: loop(controller=FTCF(ARM, filter=ImplicitFilter(700.0))),
    "second-order filter": lambda: loop(
        controller=FTCF(ARM, filter=SecondOrderFilter(100.0, THIRD))
    ),
    "proper filter": lambda: loop(controller=FTCF(ARM, filter=ProperFilter(1e5 * THIRD))),
    "ablation": lambda: loop(
        controller=FTCF(ARM, error_compensation=False, anti_saturation=False, adaptation=False)
    ),
    "command-filtered": lambda: loop(
        controller=CommandFilteredBackstepping(ARM, Gains(c2=THIRD), "proper", "none")
    ),
    "stochastic backstepping": lambda: loop(
        controller=StochasticBackstepping(ARM, Gains(k1=THIRD), "gravity")
    ),
    "finite-time backstepping": lambda: loop(
        controller=FiniteTimeBackstepping(ARM, width=THIRD, compensation="none")
    ),
    "computed torque": lambda: loop(controller=ComputedTorque(ARM, 10.0 * THIRD)),
    "PD with gravity": lambda: loop(controller=PDGravity(ARM, 10.0 * THIRD, 20.0 * THIRD)),
    "positions alone": lambda: loop(controller=PositionFeedback(ARM, noise=THIRD)),
    "Slotine and Li": lambda: loop(controller=SlotineLi(ARM, leakage=THIRD)),
    "super-twisting": lambda: loop(controller=SuperTwisting(ARM, r1=10.0 * THIRD)),
    "drawn arm, drawn nominal": lambda: loop(
        ARM.perturbed(np.random.default_rng(1)),
        controller=FTCF(ARM.perturbed(np.random.default_rng(2)), compensation="bias"),
    ),
    "a path's own robot": lambda: loop(
        Uncertainty(mass=0.2, friction=0.3).robot(load_arm("xarm7"), seed=1, path=2)
    ),
    "closed form": lambda: loop(
        PaperPendulum(m=(0.5, THIRD), as_printed=True, effort_limit=np.array([THIRD, 9.0])),
        vibration=Vibration(PaperPendulumInput(m=(0.5, THIRD)), WhiteNoise(THIRD)),
        reference=Constant([0.1, THIRD]),
    ),
    "closed form, nominal from a URDF": lambda: loop(PaperPendulum(), controller=FTCF(ARM)),
    "minimum jerk": lambda: loop(reference=MinimumJerk([0.0, THIRD], [[0.0, 0.1], [THIRD, 0.2]])),
    "table": lambda: loop(
        reference=Table([0.0, 0.1, THIRD], [[0.0, 0.1], [THIRD, 0.2], [0.3, 0.3]])
    ),
    "table with names": lambda: loop(
        reference=Table([0.0, THIRD], [[0.0, 0.1], [THIRD, 0.2]], ("elbow", "shoulder"))
    ),
    "uncertainty": lambda: loop(
        load_arm("xarm7"),
        uncertainty=Uncertainty(THIRD, friction=0.1, payload=(0.1, THIRD), distribution="bounded"),
    ),
    "correlated white noise": lambda: loop(
        excitation=WhiteNoise([[0.2, THIRD / 9], [THIRD / 9, 0.1]], "amplitude")
    ),
    "level": lambda: loop(vibration=Vibration(BaseAcceleration("x"), WhiteNoise(0.1), THIRD)),
    "joint torques": lambda: loop(vibration=Vibration(JointTorque(("elbow",)), WhiteNoise(THIRD))),
    "all joint torques": lambda: loop(vibration=Vibration(JointTorque(), WhiteNoise(THIRD))),
    "wrench": lambda: loop(
        load_arm("ur5"),
        vibration=Vibration(FrameWrench("tool0", ("x", "z"), "y"), WhiteNoise(THIRD)),
    ),
    "turning base": lambda: loop(
        vibration=Vibration(BaseMotion("x", "y"), ShapedNoise((BAND, BAND))), substeps=4
    ),
    "spectrum": lambda: shaped(BAND),
    "filter": lambda: shaped(COLOUR),
    "road": lambda: shaped(Road("B", 20 * THIRD, TRUCK)),
    "road under a filter": lambda: shaped(Road("C", 20.0, COLOUR)),
    "table by name": lambda: shaped("mil_std_810g_highway_truck_vertical"),
    "table of one's own": lambda: shaped(Standard("floor", "measured", "by us", BAND)),
    "random phase": lambda: loop(excitation=RandomPhase(BAND, 50), axes="x", substeps=4),
    "record": lambda: loop(excitation=RecordedAcceleration(RECORD, random_start=False)),
    "harmonic": lambda: loop(excitation=Harmonic([THIRD, 1.0], 10.0), axes="xz"),
    "sweep": lambda: loop(excitation=SineSweep(THIRD, 5.0, 50.0, 0.04, "linear"), axes="x"),
    "sum": lambda: loop(
        excitation=Superposition((WhiteNoise(THIRD), Harmonic(1.0, 10.0))), axes="x"
    ),
    "hardware by name": lambda: loop(hardware="ideal"),
    "hardware": lambda: loop(
        hardware=Hardware(
            Sensors(
                THIRD * 1e-5, [1e-6, THIRD * 1e-6], THIRD * 1e-3, Levant(10.0 * THIRD), dropped=0.1
            ),
            Actuators(
                [100.0 * THIRD, 50.0], 0.01, delay=1e-3, bandwidth=[np.inf, 90.0], ripple=0.1
            ),
            Accelerometer(6, 1e-3, THIRD, 90.0, 200.0, 1e-3, 2e-3, 500.0, Gyroscope(1e-4)),
            note="made up",
        ),
        reference_scale=2.0 * THIRD,
        spread={"hardware.sensors.dropped": (0.0, THIRD), "reference_scale": (THIRD, 1.0)},
        excitation=WhiteNoise(THIRD),
    ),
    "feed-forward": lambda: loop(
        controller=FeedForward(
            ARM,
            FTCF(ARM, Gains(c1=THIRD)),
            10.0 * THIRD,
            Predictor([[THIRD]], [[0.1, THIRD, 0.0]], [[THIRD], [0.0], [0.1]], np.ones((3, 1))),
        ),
        hardware=Hardware(accelerometer=Accelerometer()),
    ),
    "difference of positions": lambda: loop(
        hardware=Hardware(Sensors(velocity=BackwardDifference(10.0 * THIRD)))
    ),
    "observer": lambda: loop(hardware=Hardware(Sensors(velocity=ModelObserver(ARM, THIRD)))),
    "Kalman filter": lambda: loop(hardware=Hardware(Sensors(velocity=Kalman(ARM, THIRD)))),
    "stack": lambda: loop(excitation=Stacked((WhiteNoise(THIRD), RECORD_OF_ONE), (1, 1))),
}
RECORD_OF_ONE = RecordedAcceleration(Record(0.002, RNG.standard_normal((60, 1))))


FILE = """
duration = 0.05
seed = 5
paths = 20
record_every = 2
tolerance = 0.04
after = 0.01
quantiles = [0.1, 0.5]
chunk = 8
period = 2e-3

[specification]
error = 0.3
within = 0.02
effort = [150, 150, 150, 28, 28, 28]
share = 0.9

[arm]
robot = "ur5"

[controller]
type = "FTCF"
compensation = "bias"
gains = { c1 = 8 }
nominal = { robot = "ur5", gravity = 9.7 }

[reference]
type = "Sinusoid"
amplitude = 0.2
offset = "home"

[vibration]
input = { type = "BaseAcceleration", axes = ["x", "z"] }
excitation = { type = "WhiteNoise", intensity = 0.2 }
"""


def same_bits(experiment, path):
    again = simulate(experiment.loop, experiment.duration, seed=experiment.seed)
    return all(np.array_equal(again[name], path[name], equal_nan=True) for name in path.data_vars)
