"""The paper's pendulum loop by hand in JAX and in diffrax.

The equations are those of `ftcfa.control.ftcf` and `ftcfa.model.pendulum`, written as a user of
these libraries would: one path as functions of small arrays, `vmap` over paths, `lax.scan` over
time, double precision. With more than one device the paths are split among them, a thread each.
"""

from collections.abc import Callable
from typing import NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from jax.sharding import NamedSharding
from jax.sharding import PartitionSpec as P

from ftcfa import RBFNetwork
from ftcfa.control.gains import Gains
from ftcfa.study.reproduction import GRAVITY, INTENSITY, Q0, V0

jax.config.update("jax_enable_x64", True)

PERIOD = 1e-3
M1, M2, L1, L2 = 0.6, 0.8, 0.8, 1.2
M11, M22 = (M1 + M2) * L1**2, M2 * L2**2
MOMENT = jnp.array([(M1 + M2) * L1, M2 * L2])
LIMIT = 15.0
R1, R2 = 750.0, 180.0
G, NETWORK = Gains(), RBFNetwork()
CENTRES = jnp.linspace(-NETWORK.half_range, NETWORK.half_range, NETWORK.nodes)


class State(NamedTuple):
    """State of one path; vectors of two joints, theta a number."""

    q: jax.Array
    v: jax.Array
    psi1: jax.Array
    psi2: jax.Array
    s1: jax.Array
    s2: jax.Array
    rho: jax.Array
    theta: jax.Array


class Carry(NamedTuple):
    """State that one call hands to the next."""

    y: State
    """States of the paths, along the first axis of each array."""
    keys: jax.Array
    """Keys of the random numbers."""
    tick: jax.Array
    """Number of the sample."""


def sig(x: jax.Array, a: float) -> jax.Array:
    """sign(x) |x|^a by the exponential of a logarithm as in `ftcfa`, which is faster than pow."""
    return jnp.sign(x) * jnp.exp(a * jnp.log(jnp.maximum(jnp.abs(x), 1e-300)))


def reference(t: jax.Array) -> tuple[jax.Array, jax.Array]:
    """q_d = (1.5 sin t, sin 2t) and its derivative."""
    q_d = jnp.stack([1.5 * jnp.sin(t), jnp.sin(2.0 * t)])
    return q_d, jnp.stack([1.5 * jnp.cos(t), 2.0 * jnp.cos(2.0 * t)])


def coupling(q: jax.Array) -> tuple[jax.Array, Callable[[jax.Array], jax.Array]]:
    """The off-diagonal entry of M(q), and x -> M(q)^-1 x."""
    m12 = M2 * L1 * L2 * jnp.cos(q[1] - q[0])
    determinant = M11 * M22 - m12 * m12

    def solve(x: jax.Array) -> jax.Array:
        return jnp.stack([M22 * x[0] - m12 * x[1], M11 * x[1] - m12 * x[0]]) / determinant

    return m12, solve


def virtual_control(v1: jax.Array, dq_d: jax.Array, rho: jax.Array) -> jax.Array:
    """Virtual control alpha of the first backstepping step, (7)."""
    return -G.c1 * sig(v1, G.kappa) - 0.75 * (1.0 + G.k1) * v1 + dq_d - rho


def law(y: State, abar: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Torque u of (8), Mbar^-1 (eta(u) - u) of (11), and the growth of theta of (9)."""
    v2 = y.v - abar - y.s2 - y.rho
    X = jnp.concatenate([y.q, y.v])
    B = jnp.exp(-(X @ X - 2.0 * X.sum() * CENTRES + 4 * CENTRES**2) / NETWORK.width**2)
    BB = B @ B
    learned = y.theta * v2 * BB / (4.0 * G.tau)
    a = -G.c2 * sig(v2, G.kappa) - (0.75 * G.k2 + 1.25) * v2 - learned - y.rho
    m12, solve = coupling(y.q)
    u = jnp.stack([M11 * a[0] + m12 * a[1], m12 * a[0] + M22 * a[1]])
    gap = solve(LIMIT * jnp.tanh(u / LIMIT) - u)
    return u, gap, G.lambda_ / (4.0 * G.tau) * (v2 @ v2) ** 2 * BB


def acceleration(q: jax.Array, v: jax.Array, u: jax.Array) -> jax.Array:
    """Acceleration without noise, M^-1 (sat(u) - C v - h)."""
    turn = M2 * L1 * L2 * jnp.sin(q[1] - q[0])
    bias = jnp.stack([-turn * v[1] ** 2, turn * v[0] ** 2]) + GRAVITY * MOMENT * jnp.sin(q)
    _, solve = coupling(q)
    return solve(jnp.clip(u, -LIMIT, LIMIT) - bias)


def noise_of_base(q: jax.Array, dW: jax.Array) -> jax.Array:
    """Change of v by the noise, M^-1 Lambda(q) Sigma dW, base shaken along x and z."""
    _, solve = coupling(q)
    return solve(-INTENSITY * MOMENT * (jnp.cos(q) * dW[0] + jnp.sin(q) * dW[1]))


def initial_state() -> State:
    """State of the paper's study at time zero."""
    q, v, zero = jnp.array(Q0), jnp.array(V0), jnp.zeros(2)
    q_d, dq_d = reference(jnp.array(0.0))
    alpha = virtual_control(q - q_d, dq_d, zero)
    return State(q, v, alpha, zero, zero, zero, zero, jnp.array(0.0))


def step(y: State, t: jax.Array, normals: jax.Array) -> State:
    """One sample of the loop: controller with the implicit filter, then Euler and Maruyama."""
    h = PERIOD
    q_d, dq_d = reference(t)
    alpha = virtual_control(y.q - q_d - y.s1, dq_d, y.rho)
    b = y.psi1 - alpha + h * y.psi2
    excess = jnp.maximum(jnp.abs(b) - h**2 * R2, 0.0)
    root = (jnp.sqrt((h * R1) ** 2 + 4.0 * excess) - h * R1) / 2.0
    abar = alpha + jnp.sign(b) * root**2
    psi2 = y.psi2 - jnp.where(excess > 0.0, h * R2 * jnp.sign(b), b / h)
    u, gap, learning = law(y, abar)
    drive1 = -G.c1 * sig(y.s1, G.kappa) + (abar - alpha) + y.s2
    drive2 = -G.c2 * sig(y.s2, G.kappa)
    return State(
        q=y.q + h * y.v,
        v=y.v + h * acceleration(y.q, y.v, u) + noise_of_base(y.q, jnp.sqrt(h) * normals),
        psi1=abar,
        psi2=psi2,
        s1=(y.s1 + h * drive1) / (1.0 + h * G.k1),
        s2=(y.s2 + h * drive2) / (1.0 + h * G.k2),
        rho=(y.rho + h * gap) / (1.0 + h),
        theta=(y.theta + h * learning) / (1.0 + h * G.iota),
    )


def scan_loop(
    paths: int, ticks: int, devices: int = 1, noise: float = 1.0
) -> tuple[Carry, Callable[[Carry], Carry]]:
    """A first state, and a function that advances it by some samples: `vmap` in `lax.scan`.

    The paths are split over some CPU devices, a thread each. Zero as the factor on the normal
    deviates is for a test.
    """

    def advance(carry: Carry) -> Carry:
        def tick(y: State, k: jax.Array) -> tuple[State, None]:
            draw = jax.random.normal(jax.random.fold_in(key, k), (len(y.q), 2))
            return jax.vmap(step, in_axes=(0, None, 0))(y, k * PERIOD, noise * draw), None

        y, keys, start = carry
        key = keys[0]  # one a device: cheaper than one a path
        y, _ = jax.lax.scan(tick, y, start + jnp.arange(ticks))
        return Carry(y, keys, start + ticks)

    return _split(advance, paths, devices, keys=devices)


def diffrax_loop(
    paths: int, ticks: int, devices: int = 1, tree: bool = False
) -> tuple[Carry, Callable[[Carry], Carry]]:
    """The loop in diffrax: one stochastic differential equation with the control in its drift.

    The command filter is integrated like the rest, explicitly. Euler's method with a step of one
    period; the Brownian motion is diffrax's fastest, or with ``tree`` the one that it advises, a
    virtual Brownian tree. Arguments and results are those of `scan_loop`.
    """

    def drift(t: jax.Array, y: State, args: None) -> State:  # noqa: ARG001
        q_d, dq_d = reference(t)
        alpha = virtual_control(y.q - q_d - y.s1, dq_d, y.rho)
        error = y.psi1 - alpha
        u, gap, learning = law(y, y.psi1)
        return State(
            q=y.v,
            v=acceleration(y.q, y.v, u),
            psi1=-R1 * jnp.sign(error) * jnp.sqrt(jnp.abs(error)) + y.psi2,
            psi2=-R2 * jnp.sign(error),
            s1=-G.k1 * y.s1 - G.c1 * sig(y.s1, G.kappa) + error + y.s2,
            s2=-G.k2 * y.s2 - G.c2 * sig(y.s2, G.kappa),
            rho=-y.rho + gap,
            theta=-G.iota * y.theta + learning,
        )

    class BaseNoise(diffrax.ControlTerm):  # type: ignore[misc]
        def prod(self, vf: State, control: jax.Array) -> State:
            still = jax.tree.map(jnp.zeros_like, vf)
            return still._replace(v=noise_of_base(vf.q, control))

    def solve(y: State, key: jax.Array, start: jax.Array) -> State:
        t0, t1 = start * PERIOD, (start + ticks) * PERIOD
        if tree:
            motion = diffrax.VirtualBrownianTree(t0, t1, tol=PERIOD / 2, shape=(2,), key=key)
        else:
            motion = diffrax.UnsafeBrownianPath(shape=(2,), key=key)
        shaken = BaseNoise(lambda t, y, args: y, motion)  # noqa: ARG005
        solution = diffrax.diffeqsolve(
            diffrax.MultiTerm(diffrax.ODETerm(drift), shaken), diffrax.Euler(), t0, t1, PERIOD, y,
            adjoint=diffrax.ForwardMode(), max_steps=2 * ticks,
        )  # fmt: skip
        return jax.tree.map(lambda x: x[0], solution.ys)

    def advance(carry: Carry) -> Carry:
        y, keys, start = carry
        fresh = jax.vmap(jax.random.fold_in, in_axes=(0, None))(keys, start)
        return Carry(jax.vmap(solve, in_axes=(0, 0, None))(y, fresh, start), keys, start + ticks)

    return _split(advance, paths, devices, keys=paths)


def _split(
    advance: Callable[[Carry], Carry], paths: int, devices: int, keys: int
) -> tuple[Carry, Callable[[Carry], Carry]]:
    """A first state with some random keys, and the compiled function, split over some devices."""
    mesh = jax.sharding.Mesh(jax.devices("cpu")[:devices], "paths")
    specs = Carry(P("paths"), P("paths"), P())
    if devices > 1:
        advance = jax.shard_map(
            advance, mesh=mesh, in_specs=(specs,), out_specs=specs, check_vma=False
        )
    y = jax.tree.map(lambda x: jnp.broadcast_to(x, (paths, *x.shape)), initial_state())
    carry = Carry(y, jax.random.split(jax.random.key(0), keys), jnp.array(0))
    if devices > 1:
        carry = Carry(
            *(jax.device_put(x, NamedSharding(mesh, s)) for x, s in zip(carry, specs, strict=True))
        )
    return carry, jax.jit(advance)
