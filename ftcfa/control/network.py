"""The radial basis function network of Lemma 1, and its part in the controller."""

from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, counting_to, positive, positive_or_infinite
from ftcfa.control.filters import leaky_step
from ftcfa.control.gains import Gains
from ftcfa.parts import Parameters, Part, number_fields

APART = 1000.0
"""Largest 4 log(c_j); e^250 leaves room for sums and products."""
MOST_NODES = 1000
"""Largest number of basis functions."""


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

    nodes: Annotated[int, Check(counting_to(MOST_NODES))] = 10
    width: Annotated[float, Check(positive, "rad and rad/s")] = 4.0
    half_range: Annotated[float, Check(positive, "rad and rad/s")] = 2.0
    largest_theta: Annotated[float, Check(positive_or_infinite)] = 100.0

    varies: ClassVar[Parameters] = number_fields("width", "half_range")

    def basis_square(self, q: Traceable, v: Traceable) -> Traceable:
        """B^T B, with two exponentials instead of K.

            B^T B = exp(e) sum_j c_j t^j,   t = exp(-4 |s| d/w^2),   s = sum of the entries of X
            e = -2 |X - gamma|^2/w^2 at gamma = (r, ..., r) or its negative, whichever is nearer

        d is the distance of neighbours on the diagonal, and c_j = exp(j (K - 1 - j) 4 n d^2/w^2)
        belongs to the j-th centre from that end. t is at most 1, so nothing overflows. Centres so
        far apart that c_j would, and widths that differ from path to path, take K exponentials.
        """
        X, r = np.concatenate([q, v]), self.half_range if self.nodes > 1 else 0.0
        size, w2 = X.shape[0], self.width**2
        distance = 2.0 * r / max(1, self.nodes - 1)
        exponent = 2.0 * size * distance**2 / w2
        if not isinstance(exponent, float) or exponent * (self.nodes - 1) ** 2 > APART:
            B = self.basis(q, v)
            return B @ B
        s = np.abs(np.sum(X))
        nearest = np.exp(-2.0 * (X @ X - 2.0 * s * r + size * r**2) / w2)
        step = np.exp(-4.0 * s * distance / w2)
        *others, total = _weights(self.nodes, float(exponent))
        for weight in reversed(others):
            total = total * step + weight
        return nearest * total

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
def _weights(nodes: int, exponent: float) -> tuple[float, ...]:
    """The c_j of `RBFNetwork.basis_square`: exp(j (K - 1 - j) exponent).

    Each is correctly rounded, so that they are the same on every machine.
    """
    return tuple(float(Decimal(j * (nodes - 1 - j) * exponent).exp()) for j in range(nodes))


@lru_cache
def _positions(nodes: int, half_range: float) -> Array:
    """Positions g_k of the centres on the diagonal, shape (K,)."""
    return np.linspace(-half_range, half_range, nodes) if nodes > 1 else np.zeros(1)
