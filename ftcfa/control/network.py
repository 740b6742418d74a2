"""The radial basis function network of Lemma 1."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields, counting, positive
from ftcfa.parts import Parameters, number_fields


@dataclass(frozen=True)
class RBFNetwork:
    """Gaussian basis over X = (q, v); the paper leaves open what X is and where the centres lie.

        b_k(X) = exp(-|X - gamma_k|^2 / w^2),   gamma_k evenly on the diagonal of [-r, r]^(2n)

    Attributes:
        nodes: K, the number of basis functions.
        width: w [rad and rad/s].
        half_range: r, half the side of the box of centres [rad and rad/s].
    """

    nodes: Annotated[int, Check(counting)] = 10
    width: Annotated[float, Check(positive)] = 4.0
    half_range: Annotated[float, Check(positive)] = 2.0

    varies: ClassVar[Parameters] = number_fields("width", "half_range")

    def __post_init__(self) -> None:
        check_fields(self)

    def basis(self, q: Array, v: Array) -> Array:
        """B(X), shape (K,)."""
        X = np.concatenate([q, v])  # (2n,)
        g = _positions(self.nodes, self.half_range)  # (K,), gamma_k = g_k (1, ..., 1)
        distance = X @ X - 2.0 * np.sum(X) * g + X.shape[0] * g**2
        return np.exp(-distance / self.width**2)


@lru_cache
def _positions(nodes: int, half_range: float) -> Array:
    """Where the centres lie on the diagonal, shape (K,)."""
    return np.linspace(-half_range, half_range, nodes) if nodes > 1 else np.zeros(1)
