"""Shaping filters: coloured noise as the output of a linear system driven by white noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag, matrix_balance

from ftcfa.arrays import Array
from ftcfa.checks import numbers, positive
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.portable import exponential, product, root, solve

FIRST_STEP = 0.25
"""Norm of A times the step at which the matrix exponential is computed, before doubling."""
FORGOTTEN = 1e-18
"""What is left of a state after a time in which its covariance has become stationary."""
NO_GAIN = 1e-9
"""Gain at 0 Hz, relative to the largest at a resonance, that counts as zero despite rounding."""


@dataclass(frozen=True, eq=False)
class SampledFilter:
    """A shaping filter over steps of one length: exact in law at the ends of the steps.

        Y_k     = C x_k + D n_k,        Y_k: integral of y over step k
        x_{k+1} = A x_k + B n_k,        n_k: independent standard normals
        x_0     = root n
        W_k     = E x_k,                W_{k+1} = W_k + Y_k
        U_k     = F x_k,                U' = W

    Attributes:
        step: h [s].
        A: Shape (n, n).
        B: Shape (n, r).
        C: Shape (p, n).
        D: Shape (p, r).
        root: Root of the stationary covariance of x, shape (n, n): x_0 = root n is stationary.
        E: Matrix of the stationary integral W of y, shape (p, n); see `LinearFilter.integral`.
        F: Matrix of the stationary integral U of W, shape (p, n).
        integrable: Whether each output has both integrals, shape (p,).
    """

    step: float
    A: Array
    B: Array
    C: Array
    D: Array
    root: Array
    E: Array
    F: Array
    integrable: npt.NDArray[np.bool_]

    @property
    def normals(self) -> int:
        """r, the number of standard normal deviates in each step."""
        return int(self.B.shape[1])

    def covariance(self, lag: int) -> Array:
        """E[Y_{k+lag} Y_k^T] of the stationary sequence, lag >= 0, shape (p, p)."""
        P = self.root @ self.root.T
        if lag == 0:
            return self.C @ P @ self.C.T + self.D @ self.D.T
        cross = self.A @ P @ self.C.T + self.B @ self.D.T  # E[x_{k+1} Y_k^T], (n, p)
        return self.C @ np.linalg.matrix_power(self.A, lag - 1) @ cross


def joined(filters: Sequence[SampledFilter]) -> SampledFilter:
    """Independent filters over the same steps as one, block-diagonal: outputs side by side."""
    A, B, C, D, root, E, F = (
        block_diag(*(getattr(one, name) for one in filters))
        for name in ("A", "B", "C", "D", "root", "E", "F")
    )
    integrable = np.concatenate([one.integrable for one in filters])
    return SampledFilter(filters[0].step, A, B, C, D, root, E, F, integrable)


@dataclass(frozen=True, eq=False)
class LinearFilter:
    """A stable, strictly proper linear system driven by white noise of unit intensity.

        dx = A x dt + B dW,   y = C x

    Its one-sided spectral density per Hz is 2 H H^*, H(f) = C (2 pi i f - A)^-1 B.

    Attributes:
        A: Shape (n, n); all eigenvalues have a negative real part [1/s].
        B: Shape (n, m).
        C: Shape (p, n).

    Raises:
        ShapeError: If the shapes do not fit.
        ParameterError: If an entry is not finite, or A is not stable.
    """

    A: Array
    B: Array
    C: Array

    def __post_init__(self) -> None:
        for name in ("A", "B", "C"):
            subject, given = f"LinearFilter {name}", getattr(self, name)
            matrix = numbers(subject, given, "a matrix of numbers", field=name)
            if not np.all(np.isfinite(matrix)):
                raise ParameterError(subject, f"{matrix.tolist()}", "finite numbers", field=name)
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        A, B, C = self.A.shape, self.B.shape, self.C.shape
        n = A[0] if A else 0
        if n == 0 or (n, n) != A or len(B) != 2 or len(C) != 2 or B[0] != n or C[1] != n:
            got = f"shapes {A}, {B}, {C}"
            raise ShapeError("LinearFilter A, B, C", got, "(n, n), (n, m), (p, n)")
        worst = float(np.linalg.eigvals(self.A).real.max())
        if worst >= 0:
            got, remedy = f"an eigenvalue of real part {worst:.3g}", "only a stable filter has a"
            raise ParameterError(
                "LinearFilter A", got, "all real parts < 0", f"{remedy} stationary state", field="A"
            )

    @property
    def order(self) -> int:
        """n, the number of states."""
        return len(self.A)

    @property
    def inputs(self) -> int:
        """m, the number of inputs."""
        return int(self.B.shape[1])

    @property
    def outputs(self) -> int:
        """p, the number of outputs."""
        return len(self.C)

    def response(self, f: npt.ArrayLike) -> npt.NDArray[np.complex128]:
        """H(f), shape (F, p, m) for f of shape (F,) [Hz]."""
        s = 2j * np.pi * np.atleast_1d(np.asarray(f, dtype=float))
        resolvent = s[:, None, None] * np.eye(self.order) - self.A
        return self.C @ np.linalg.solve(resolvent, np.broadcast_to(self.B, (len(s), *self.B.shape)))

    def density(self, f: npt.ArrayLike) -> Array:
        """One-sided spectral density of each output per Hz, shape (F, p) for f of shape (F,)."""
        return 2.0 * np.sum(np.abs(self.response(f)) ** 2, axis=2)

    def covariance(self) -> Array:
        """Stationary covariance P of the state: A P + P A^T + B B^T = 0, shape (n, n)."""
        return self._covariance.copy()

    def rms(self) -> Array:
        """Stationary standard deviation of each output, shape (p,)."""
        return np.sqrt(np.einsum("ij,jk,ik->i", self.C, self._covariance, self.C))

    def scaled(self, factor: float) -> "LinearFilter":
        """The filter with its output times a factor."""
        return LinearFilter(self.A, self.B, self.C * factor)

    def integral(self) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Stationary integral W of each output y that has one, of mean zero.

            W = E x,   E = C A^-1,   dW = y dt + E B dw

        An output has one if its gain at 0 Hz, H(0) = -E B, is zero compared with its gain at the
        frequencies of the poles.

        Returns:
            E, shape (p, n), zero for the other outputs; and whether each has one, shape (p,).
        """
        A, B, C, x = self._balanced
        E = solve(A.T, C.T).T
        poles = np.abs(np.linalg.eigvals(A)) / (2.0 * np.pi)
        largest = np.sqrt(0.5 * LinearFilter(A, B, C).density(poles).max(axis=0))
        integrable = np.linalg.norm(E @ B, axis=1) <= NO_GAIN * largest
        return np.where(integrable[:, None], E / x, 0.0), integrable

    def discretise(self, step: float) -> SampledFilter:
        """Filter over steps of length h: the state and the integral of y are jointly exact in law.

        With z = (integral of y, x), dz = F z dt + G dW, F = [[0, C], [0, A]], G = [0; B]:

            Phi(h) = e^(F h),   Q(h) = integral over s in [0, h] of Phi(s) G G^T Phi(s)^T

        Both come from one matrix exponential (Van Loan 1978, IEEE Trans. Automatic Control 23) of
        a short step, followed by doublings

            Q(2h) = Q(h) + Phi(h) Q(h) Phi(h)^T,   Phi(2h) = Phi(h)^2,

        which add positive terms only and so stay accurate for any h. Where y has a stationary
        integral E x, Q implies E B = D. The root of Q meets this to half of the digits, and B is
        corrected to meet it to all.

        Args:
            step: h [s].

        Returns:
            The filter with r <= n + p normals in each step, r the rank of Q; output k needs only
            the first k of them.
        """
        positive("step", step, "s")
        n, p = self.order, self.outputs
        A, B, C, x = self._balanced
        rate = float(_scale(np.linalg.norm(A)))
        y = _scale(np.linalg.norm(C, axis=1)) / rate  # (p,)
        F = np.zeros((p + n, p + n))
        F[:p, p:], F[p:, p:] = C / y[:, None], A
        G = np.vstack([np.zeros((p, self.inputs)), B])
        doublings = max(0, int(np.ceil(np.log2(rate * step / FIRST_STEP))))
        Phi, Q = _van_loan(F, G, step / 2**doublings)
        for _ in range(doublings):
            Q, Phi = doubled(Q, Phi)
        z = np.concatenate([y, x])
        root = root_of_covariance(Q * np.outer(z, z))  # (p + n, r)
        Phi = Phi * z[:, None] / z
        D, B = root[:p], root[p:]
        E, integrable = self.integral()
        second, twice = LinearFilter(self.A, self.B, E).integral()
        rows = np.flatnonzero(integrable)
        if rows.size:
            short = D[rows] - product(E[rows], B)  # (rows, r)
            inner = E[rows] * x
            correction = solve(product(inner, inner.T), short)
            B = B + x[:, None] * product(inner.T, correction)
        start = root_of_covariance(self._covariance)
        x0 = np.pad(start, ((0, 0), (0, n - start.shape[1])))  # (n, n)
        both = integrable & twice
        return SampledFilter(step, Phi[p:, p:], B, Phi[:p, p:], D, x0, E, second, both)

    @cached_property
    def _balanced(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C for states scaled to size one, and the sizes x of the states, shape (n,)."""
        x = _nonzero(np.sqrt(np.diag(self._covariance)))
        return self.A * x / x[:, None], self.B / x[:, None], self.C * x, x

    @cached_property
    def _covariance(self) -> Array:
        _, (size, _) = matrix_balance(self.A, permute=False, separate=True)  # (n,)
        A, B = self.A * size / size[:, None], self.B / size[:, None]
        Phi, P = _van_loan(A, B, FIRST_STEP / float(_scale(np.linalg.norm(A))))
        while np.abs(Phi).max() > FORGOTTEN:
            P, Phi = doubled(P, Phi)
        P = P * np.outer(size, size)
        return 0.5 * (P + P.T)


def root_of_covariance(Q: Array) -> Array:
    """Root R of a positive semidefinite Q = R R^T, shape (k, r), r the numerical rank of Q.

    Cholesky's factor of the correlation matrix, so that states of very different size all keep full
    relative accuracy, without the columns whose pivots are rounding errors.
    """
    size = np.sqrt(np.maximum(np.diag(Q), 0.0))  # (k,)
    safe = _nonzero(size)
    smallest = len(Q) * np.finfo(float).eps
    L = root(0.5 * (Q + Q.T) / np.outer(safe, safe), smallest)
    return size[:, None] * L[:, L.any(axis=0)]


def doubled(Q: Array, Phi: Array) -> tuple[Array, Array]:
    """Q(2h) and Phi(2h) from Q(h) and Phi(h)."""
    return Q + product(product(Phi, Q), Phi.T), product(Phi, Phi)


def _scale(sizes: npt.ArrayLike) -> Array:
    """The next powers of two, one for zero: scaling by them rounds nothing."""
    _, exponents = np.frexp(np.asarray(sizes, dtype=float))
    return np.ldexp(1.0, exponents)


def _nonzero(sizes: Array) -> Array:
    """Sizes to divide by, with one in place of zero."""
    return np.where(sizes > 0, sizes, 1.0)


def _van_loan(F: Array, G: Array, step: float) -> tuple[Array, Array]:
    """Phi(h) and Q(h) from the exponential of [[-F, G G^T], [0, F^T]] h."""
    k = len(F)
    block = np.block([[-F, product(G, G.T)], [np.zeros((k, k)), F.T]])
    E = exponential(block * step, 2)
    Phi = E[k:, k:].T
    Q = product(Phi, E[:k, k:])
    return Phi, 0.5 * (Q + Q.T)
