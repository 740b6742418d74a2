"""The radial basis function network of Lemma 1, and its part in the controller."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, counting, positive, positive_or_infinite
from ftcfa.control.filters import leaky_step
from ftcfa.control.gains import Gains
from ftcfa.parts import Parameters, Part, number_fields


@dataclass(frozen=True)
class RBFNetwork(Part):
    """Gaussian basis over X = (q, v).

        b_k(X) = exp(-|X - gamma_k|^2 / w^2),   gamma_k evenly on the diagonal of [-r, r]^(2n)

    The paper says neither what X is nor where in the box the centres gamma_k lie.

    Attributes:
        nodes: K, the number of basis functions.
        width: w [rad and rad/s].
        half_range: r, half the side of the box of centres [rad and rad/s].
        largest_theta: Bound onto which the estimate theta >= 0 is projected; infinity for the
            paper's law, which has none.
    """

    nodes: Annotated[int, Check(counting)] = 10
    width: Annotated[float, Check(positive, "rad and rad/s")] = 4.0
    half_range: Annotated[float, Check(positive, "rad and rad/s")] = 2.0
    largest_theta: Annotated[float, Check(positive_or_infinite)] = 100.0

    varies: ClassVar[Parameters] = number_fields("width", "half_range")

    def basis(self, q: Traceable, v: Traceable) -> Traceable:
        """B(X), shape (K,)."""
        X = np.concatenate([q, v])  # (2n,)
        g = _positions(self.nodes, self.half_range)  # (K,), gamma_k = g_k (1, ..., 1)
        distance = X @ X - 2.0 * np.sum(X) * g + X.shape[0] * g**2
        return np.exp(-distance / self.width**2)


def network_acceleration(gains: Gains, v2: Traceable, theta: Traceable, BB: Traceable) -> Traceable:
    """Part of the network in (8), theta v2 (B^T B)/(4 tau), shape (n,) [rad/s^2].

    v2 is the velocity error that the law uses, shape (n,) [rad/s]; theta the estimate of the
    squared norm of the network's weights, shape (1,); BB = B^T B.
    """
    return theta * v2 * BB / (4.0 * gains.tau)


def adapted(
    gains: Gains, largest: float, theta: Traceable, v2: Traceable, BB: Traceable, period: float
) -> Traceable:
    """Theta after a period.

        theta' = -iota theta + lambda/(4 tau) (v2^T v2)^2 (B^T B)          (9)

    projected onto [0, largest]. As printed there is no bound: a wrong velocity of 300 rad/s drives
    theta to 1e6, where its part of the torque turns over from one sample to the next. The other
    arguments are those of `network_acceleration`.
    """
    drive = gains.lambda_ / (4.0 * gains.tau) * (v2 @ v2) ** 2 * BB
    return np.minimum(leaky_step(theta, gains.iota, drive, period), largest)


@lru_cache
def _positions(nodes: int, half_range: float) -> Array:
    """Positions g_k of the centres on the diagonal, shape (K,)."""
    return np.linspace(-half_range, half_range, nodes) if nodes > 1 else np.zeros(1)
