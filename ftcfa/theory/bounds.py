"""`bounds`: Theorem 1 applied to a closed loop."""

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_number, not_negative, probability
from ftcfa.control.anti_saturation import smooth_saturation
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import joint_box, mass_matrix_bounds
from ftcfa.theory.assumptions import check_white, paper_law
from ftcfa.theory.gain_conditions import default_weight
from ftcfa.theory.theorem1 import Bounds


def bounds(
    loop: ClosedLoop,
    *,
    theta: float = 0.0,
    eps: float = 0.0,
    pi1: float = 0.0,
    sigma: float = 0.5,
    weight: float | None = None,
) -> Bounds:
    """Theorem 1 with its proof repaired, for any number of joints n.

        Delta = min{ 4^p c_i kappa/(kappa+3), (4/w_s)^p c_i s, iota }
        Gamma = |etabar|^4/(4 Mmin^4) + tau + eps^2 + w_s pi1^4/4 + iota theta^2/(2 lambda)
                + iota (1-p) p^(p/(1-p))
        s     = w_s - kappa N^(1+3/kappa)/(kappa+3),   N = n^((1-kappa)/2),   p = (3+kappa)/4

    The effort limits of the plant and of the nominal arm may differ: etabar_i is the largest
    |sat(u) - eta(u)|, which is (1 - tanh 1) u* where they are equal.

    Args:
        loop: A loop with the paper's controller, whose nominal arm is an `Arm`.
        theta: Bound of |H|^2, the squared norm of the network's weights.
        eps: Largest error of the network, (24).
        pi1: Largest filter error |abar - alpha| [rad/s].
        sigma: Share of Delta that the bound of the first-entry time uses; a larger share makes
            that bound shorter and Vinf larger.
        weight: w_s; by default `default_weight`, which at the paper's gains is 1 for two joints
            and 2.56 for seven. `Bounds.best_weight` searches for a better one.

    Raises:
        ParameterError: If the controller is not the paper's, a part of it is switched off, the
            noise is not white, or a number is out of range.
    """
    law = paper_law(loop)
    check_white(loop)
    for name, value in (("theta", theta), ("eps", eps), ("pi1", pi1)):
        not_negative(f"bounds {name}", value)
    probability("bounds sigma", sigma)
    if weight is not None and not (is_number(weight) and weight > 0.25):
        raise ParameterError("bounds weight", repr(weight), "a number > 1/4")
    nominal = law.nominal
    if not isinstance(nominal, Arm):
        got = f"a {type(nominal).__name__}"
        raise ParameterError("bounds nominal arm", got, "an Arm, which knows its joint range")
    Mmin, Mmax = mass_matrix_bounds(nominal)
    lower, upper = joint_box(nominal)
    return Bounds(
        law=law,
        theta=theta,
        eps=eps,
        pi1=pi1,
        sigma=sigma,
        weight=default_weight(loop.arm.n, law.gains) if weight is None else weight,
        Mmin=Mmin,
        Mmax=Mmax,
        etabar=saturation_gap(loop.arm.effort_limit, nominal.effort_limit),
        V0=_initial_value(loop, theta, law.gains.lambda_),
        joint_range=float(np.linalg.norm(upper - lower)),
    )


def saturation_gap(actual: Array, nominal: Array) -> Array:
    """Largest |sat(u) - eta(u)| over all u, called etabar, shape (n,) [N m or N].

    sat clips at the plant's actual limit a, and eta(u) = b tanh(u/b) has the limit b of the nominal
    arm, shape (n,) each. Their difference rises to a - b tanh(a/b) at u = a and falls to a - b as u
    grows.
    """
    peak = actual - smooth_saturation(actual, nominal)
    return np.maximum(np.abs(peak), np.abs(actual - nominal))


def _initial_value(loop: ClosedLoop, theta: float, lambda_: float) -> float:
    """V at the first sample, where s1 = s2 = 0."""
    desired = loop.first_desired
    signals, *_ = loop.control(loop.init(desired), desired)
    fourth = sum(float(signals[name] @ signals[name]) ** 2 for name in ("v1", "v2"))
    return fourth / 4 + (theta - float(signals["theta"])) ** 2 / (2 * lambda_)
