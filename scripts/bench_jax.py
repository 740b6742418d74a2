"""The paper's pendulum loop by hand in JAX and in diffrax: the rivals of `bench.py`.

The equations are those of `ftcfa.control.ftcf` and `ftcfa.model.pendulum`, written as a user of
these libraries would: one path as functions of small arrays, `vmap` over paths, `lax.scan` over
time, double precision. With more than one device the paths are split among them, a thread each.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from ftcfa import RBFNetwork
from ftcfa.control.ftcf import Gains
from ftcfa.study.reproduction import GRAVITY, INTENSITY, Q0, V0

jax.config.update("jax_enable_x64", True)

Run = Callable[[Any], Any]
"""Advances a state by the ticks that it was made for."""

PERIOD = 1e-3
M1, M2, L1, L2 = 0.6, 0.8, 0.8, 1.2
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


def sig(x: jax.Array, a: float) -> jax.Array:
    """sign(x) |x|^a; the exponential of a logarithm as in `ftcfa`, for it is faster than pow."""
    return jnp.sign(x) * jnp.exp(a * jnp.log(jnp.maximum(jnp.abs(x), 1e-300)))


def reference(t: jax.Array) -> tuple[jax.Array, jax.Array]:
    """q_d = (1.5 sin t, sin 2t) and its derivative."""
    q_d = jnp.stack([1.5 * jnp.sin(t), jnp.sin(2.0 * t)])
    return q_d, jnp.stack([1.5 * jnp.cos(t), 2.0 * jnp.cos(2.0 * t)])


def coupling(q: jax.Array) -> tuple[jax.Array, Callable[[jax.Array], jax.Array]]:
    """The off-diagonal entry of M(q), and x -> M(q)^-1 x."""
    m12 = M2 * L1 * L2 * jnp.cos(q[1] - q[0])
    m11, m22 = (M1 + M2) * L1**2, M2 * L2**2
    determinant = m11 * m22 - m12 * m12
    return (
        m12,
        lambda x: jnp.stack([m22 * x[0] - m12 * x[1], m11 * x[1] - m12 * x[0]]) / determinant,
    )


def virtual_control(v1: jax.Array, dq_d: jax.Array, rho: jax.Array) -> jax.Array:
    """(7)."""
    return -G.c1 * sig(v1, G.kappa) - 0.75 * (1.0 + G.k1) * v1 + dq_d - rho


def law(y: State, abar: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """(8), the gap of (11) and the learning of (9): u, Mbar^-1 (eta(u) - u), drive of theta."""
    v2 = y.v - abar - y.s2 - y.rho
    X = jnp.concatenate([y.q, y.v])
    B = jnp.exp(-(X @ X - 2.0 * X.sum() * CENTRES + 4 * CENTRES**2) / NETWORK.width**2)
    BB = B @ B
    a = (
        -G.c2 * sig(v2, G.kappa)
        - (0.75 * G.k2 + 1.25) * v2
        - y.theta * v2 * BB / (4.0 * G.tau)
        - y.rho
    )
    m12, solve = coupling(y.q)
    u = jnp.stack([(M1 + M2) * L1**2 * a[0] + m12 * a[1], m12 * a[0] + M2 * L2**2 * a[1]])
    gap = solve(LIMIT * jnp.tanh(u / LIMIT) - u)
    return u, gap, G.lambda_ / (4.0 * G.tau) * (v2 @ v2) ** 2 * BB


def acceleration(q: jax.Array, v: jax.Array, u: jax.Array) -> jax.Array:
    """M^-1 (sat(u) - C v - h)."""
    turn = M2 * L1 * L2 * jnp.sin(q[1] - q[0])
    bias = jnp.stack([-turn * v[1] ** 2, turn * v[0] ** 2]) + GRAVITY * MOMENT * jnp.sin(q)
    _, solve = coupling(q)
    return solve(jnp.clip(u, -LIMIT, LIMIT) - bias)


def shaking(q: jax.Array, dW: jax.Array) -> jax.Array:
    """M^-1 Lambda(q) Sigma dW for a base shaken along x and z, Sigma as printed."""
    _, solve = coupling(q)
    return solve(-INTENSITY * MOMENT * (jnp.cos(q) * dW[0] + jnp.sin(q) * dW[1]))


def initial_state() -> State:
    """The paper's, at time zero."""
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
        v=y.v + h * acceleration(y.q, y.v, u) + shaking(y.q, jnp.sqrt(h) * normals),
        psi1=abar,
        psi2=psi2,
        s1=(y.s1 + h * drive1) / (1.0 + h * G.k1),
        s2=(y.s2 + h * drive2) / (1.0 + h * G.k2),
        rho=(y.rho + h * gap) / (1.0 + h),
        theta=(y.theta + h * learning) / (1.0 + h * G.iota),
    )


def scan_loop(paths: int, ticks: int, devices: int, noise: float = 1.0) -> tuple[Any, Run]:
    """Initial state and function of the loop in JAX; noise scales the standard deviation."""
    mesh = Mesh(jax.devices("cpu")[:devices], "paths")
    shared, split = (NamedSharding(mesh, PartitionSpec(*axes)) for axes in ((), ("paths",)))

    def advance(carry: tuple[State, jax.Array, jax.Array]) -> Any:
        def tick(carry: tuple[State, jax.Array], k: jax.Array) -> Any:
            y, key = carry
            draw = jax.random.normal(jax.random.fold_in(key[0], k), (len(y.q), 2))
            y = jax.vmap(step, in_axes=(0, None, 0))(y, k * PERIOD, noise * draw)
            return (y, key), None

        y, keys, start = carry
        (y, _), _ = jax.lax.scan(tick, (y, keys), start + jnp.arange(ticks))
        return y, keys, start + ticks

    specs = (PartitionSpec("paths"), PartitionSpec("paths"), PartitionSpec())
    run = jax.jit(jax.shard_map(advance, mesh=mesh, in_specs=(specs,), out_specs=specs))
    y = jax.tree.map(lambda x: jnp.broadcast_to(x, (paths, *x.shape)), initial_state())
    keys = jax.random.split(jax.random.key(0), devices)
    state = (jax.device_put(y, split), jax.device_put(keys, split))
    return (*state, jax.device_put(jnp.array(0), shared)), run


def diffrax_loop(paths: int, ticks: int, devices: int) -> tuple[Any, Run]:
    """The same with diffrax: everything a state of one stochastic differential equation.

    The command filter is then integrated like the rest, explicitly.
    """
    import diffrax

    def drift(t: jax.Array, y: State, args: Any) -> State:  # noqa: ARG001
        q_d, dq_d = reference(t)
        alpha = virtual_control(y.q - q_d - y.s1, dq_d, y.rho)
        error = y.psi1 - alpha
        u, gap, learning = law(y, y.psi1)
        return State(
            q=y.v,
            v=acceleration(y.q, y.v, u),
            psi1=-R1 * sig(error, 0.5) + y.psi2,
            psi2=-R2 * jnp.sign(error),
            s1=-G.k1 * y.s1 - G.c1 * sig(y.s1, G.kappa) + error + y.s2,
            s2=-G.k2 * y.s2 - G.c2 * sig(y.s2, G.kappa),
            rho=-y.rho + gap,
            theta=-G.iota * y.theta + learning,
        )

    class Shaking(diffrax.ControlTerm):
        def prod(self, vf: Any, control: jax.Array) -> State:
            zero = jax.tree.map(jnp.zeros_like, vf)
            return zero._replace(v=shaking(vf.q, control))

    def solve(y: State, key: jax.Array, start: jax.Array) -> State:
        path = diffrax.UnsafeBrownianPath(shape=(2,), key=key)
        terms = diffrax.MultiTerm(
            diffrax.ODETerm(drift),
            Shaking(lambda t, y, args: y, path),  # noqa: ARG005
        )
        t0 = start * PERIOD
        solution = diffrax.diffeqsolve(
            terms,
            diffrax.Euler(),
            t0,
            t0 + ticks * PERIOD,
            PERIOD,
            y,
            adjoint=diffrax.ForwardMode(),
            max_steps=2 * ticks,
        )
        return jax.tree.map(lambda x: x[0], solution.ys)

    mesh = Mesh(jax.devices("cpu")[:devices], "paths")

    def advance(carry: Any) -> Any:
        y, keys, start = carry
        now = jax.vmap(jax.random.fold_in, in_axes=(0, None))(keys, start)
        return jax.vmap(solve, in_axes=(0, 0, None))(y, now, start), keys, start + ticks

    specs = (PartitionSpec("paths"), PartitionSpec("paths"), PartitionSpec())
    run = jax.jit(
        jax.shard_map(advance, mesh=mesh, in_specs=(specs,), out_specs=specs, check_vma=False)
    )
    split = NamedSharding(mesh, PartitionSpec("paths"))
    y = jax.tree.map(lambda x: jnp.broadcast_to(x, (paths, *x.shape)), initial_state())
    keys = jax.random.split(jax.random.key(0), paths)
    return (jax.device_put(y, split), jax.device_put(keys, split), jnp.array(0)), run
