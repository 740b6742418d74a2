"""The radial basis function network of Lemma 1."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError


@dataclass(frozen=True)
class RBFNetwork:
    """Gaussian basis over X = (q, v); the paper leaves open what X is and where the centres lie.

        b_k(X) = exp(-|X - gamma_k|^2 / w^2),   gamma_k evenly on the diagonal of [-r, r]^(2n)

    Attributes:
        nodes: K, the number of basis functions.
        width: w [rad and rad/s].
        half_range: r, half the side of the box of centres [rad and rad/s].
    """

    nodes: int = 10
    width: float = 4.0
    half_range: float = 2.0

    def __post_init__(self) -> None:
        if isinstance(self.nodes, bool) or not isinstance(self.nodes, int) or self.nodes < 1:
            raise ParameterError("RBFNetwork nodes", repr(self.nodes), "an integer >= 1")
        for name in ("width", "half_range"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ParameterError(f"RBFNetwork {name}", repr(value), "a number > 0")

    def basis(self, q: Array, v: Array) -> Array:
        """B(X), shape (K,)."""
        X = np.concatenate([q, v])  # (2n,)
        distance = np.sum((X - _diagonal(self.nodes, self.half_range, X.shape[0])) ** 2, axis=1)
        return np.exp(-distance / self.width**2)


@lru_cache
def _diagonal(nodes: int, half_range: float, dimension: int) -> Array:
    """Centres gamma, shape (K, 2n)."""
    positions = np.linspace(-half_range, half_range, nodes) if nodes > 1 else np.zeros(1)
    return np.tile(positions[:, None], (1, dimension))
