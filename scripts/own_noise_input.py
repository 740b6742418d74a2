"""How to write a noise input of your own: gusts of wind on the forearm of a UR5.

    python scripts/own_noise_input.py [--paths N]

The wind blows along the world's x with the mean U plus the gust u. On a cylinder of diameter d that
has the area A(q) across the wind it exerts

    F = 1/2 rho c_D A(q) (U + u)^2,   of which rho c_D A(q) U u is random to first order,

so xi is the gust u [m/s] and Lambda(q) = rho c_D A(q) U J_x(q)^T, with J_x the Jacobian of the
forearm's middle along x. The steady force of the mean wind is left out. The gusts have Dryden's
longitudinal spectrum (MIL-F-8785C), which is one linear filter:

    u' = -(U/L) u + sigma sqrt(2 U/L) w,   w white of unit intensity,   rms u = sigma
"""

import argparse
from dataclasses import replace

import numpy as np

import ftcfa

DENSITY, DRAG = 1.225, 1.2
"""Density of air [kg/m^3], and drag coefficient of a cylinder across the wind [1]."""
DIAMETER = 0.1
"""Diameter of the forearm [m]."""
WIND, GUST, LENGTH = 15.0, 4.0, 10.0
"""U, sigma [m/s] and L [m]: a gale close to the ground."""
ELBOW = 2
"""Number of the joint that turns the forearm."""


def gusts_on_the_forearm(arm, q):
    """Matrix Lambda(q) from the gust [m/s] to the joint torques, shape (6, 1) [N m s/m].

    It is plain NumPy without branches on values, so it is compiled like the rest of the loop.
    """
    elbow, wrist = arm.frame_jacobian("forearm_link", q), arm.frame_jacobian("wrist_1_link", q)
    x, y, z = wrist[3:, ELBOW]  # axis of the elbow, in the world
    swing = wrist[:3, ELBOW]  # axis x forearm, as long as the forearm (3,)
    across = np.stack([swing[2] * x - swing[0] * z, swing[0] * y - swing[1] * x])  # forearm's y, z
    area = DIAMETER * np.sqrt(across @ across)
    middle = 0.5 * (elbow[0] + wrist[0])  # J_x (6,)
    return np.reshape(DENSITY * DRAG * WIND * area * middle, (6, 1))


def gusts():
    """Noise with Dryden's spectrum of longitudinal gusts."""
    rate = WIND / LENGTH
    return ftcfa.ShapedNoise(ftcfa.LinearFilter([[-rate]], [[GUST * np.sqrt(2.0 * rate)]], [[1.0]]))


def error(loop, paths):
    """Root mean square of the overall tracking error after two seconds [rad]."""
    late = ftcfa.simulate_paths(loop, paths, 4.0, record_every=10).sel(time=slice(2, None))
    return np.sqrt((late.ote**2).mean().item())


def main():
    """Hold postures with more or less of the forearm across the wind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--paths", type=int, default=256, help="number of paths of each posture")
    paths = parser.parse_args().paths
    arm = ftcfa.load_arm("ur5")
    print(f"UR5 in gusts of {GUST:g} m/s rms on a wind of {WIND:g} m/s, {paths} paths")
    print("forearm          torque of gusts, rms   OTE, rms   without wind")
    for name, elbow in (("across the wind", 0.0), ("at 45 degrees", 0.25), ("along the wind", 0.5)):
        q = np.array([0.0, -0.5, elbow, 0.0, 0.0, 0.0]) * np.pi
        loop = ftcfa.ClosedLoop(
            arm,
            ftcfa.FTCF(arm, compensation="bias"),
            ftcfa.Constant(q),
            ftcfa.Vibration(gusts_on_the_forearm, gusts()),
            q0=q,
        )
        torque = GUST * np.linalg.norm(gusts_on_the_forearm(arm, q))
        shaken, still = error(loop, paths), error(replace(loop, vibration=None), 1)
        print(f"{name:16} {torque:16.2f} N m {1e6 * shaken:7.2f} urad {1e6 * still:9.2f} urad")


if __name__ == "__main__":
    main()
