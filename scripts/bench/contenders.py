"""The contenders: the engines of ftcfa, and the same arm in Pinocchio and in MuJoCo."""

from typing import Any

import numpy as np
import pinocchio as pin
from timing import Contender

from ftcfa import ClosedLoop, load_arm, simulate, simulate_paths
from ftcfa.arrays import Array

PATHS = 1024
ROBOTS = 64
"""Number of different robots among the paths of a varied run."""


def compiled(
    loop: ClosedLoop, threads: int, paths: int = PATHS, values: dict[str, Array] | None = None
) -> Contender:
    """The compiled engine; it records the first sample. `varied` draws values for each path."""

    def run(ticks: int) -> None:
        duration = (ticks - 1) * loop.period
        simulate_paths(loop, paths, duration, vary=values, record_every=ticks, threads=threads)

    name = "ftcfa" if values is None else "ftcfa, varied"
    return Contender(name, threads, run, paths, has_fixed=True)


def varied(loop: ClosedLoop) -> dict[str, Array]:
    """Another robot and other gains for every path."""
    rng = np.random.default_rng(1)
    nominal, gains = loop.controller.nominal, loop.controller.gains
    robots = np.array([nominal.perturbed(rng).inertias for _ in range(ROBOTS)])
    drawn = {
        f"controller.gains.{name}": value * rng.uniform(0.9, 1.1, PATHS)
        for name, value in vars(gains).items()
    }
    return {"arm.inertias": robots[np.arange(PATHS) % len(robots)], **drawn}


def interpreted(loop: ClosedLoop) -> Contender:
    """The interpreted engine; it records the first sample."""

    def run(ticks: int) -> None:
        duration = (ticks - 1) * loop.period
        simulate(loop, duration, record_every=ticks, engine="interpreted")

    return Contender("interpreted", 1, run, paths=1, has_fixed=True)


def bare_model(arm: Any) -> pin.Model:
    """The model of an arm with its locked joints welded.

    Neither `aba` nor MuJoCo has mimic joints like the pendulum's: its twin in relative angles is
    used instead.
    """
    if arm.name == "double_pendulum":
        arm = load_arm("double_pendulum_relative")
    locked = [i + 1 for i, moves in enumerate(arm.G.any(axis=1)) if not moves]
    return pin.buildReducedModel(arm.model, locked, arm.g0)


def aba(model: pin.Model, threads: int) -> Contender:
    """Pinocchio's forward dynamics; a tick is one batch."""
    pool, rng = pin.ModelPool(model, threads), np.random.default_rng(0)
    q, v, tau = (np.asfortranarray(rng.uniform(-1, 1, (model.nv, PATHS))) for _ in range(3))
    acceleration = np.zeros_like(q)

    def run(ticks: int) -> None:
        for _ in range(ticks):
            pin.abaInParallel(threads, pool, q, v, tau, acceleration)

    return Contender("aba", threads, run, PATHS)


def mujoco_arm(model: pin.Model) -> Any:
    """The same arm for MuJoCo.

    Raises:
        RuntimeError: If its mass matrix differs from Pinocchio's.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 1e-3, model.gravity.linear
    bodies, joints = [spec.worldbody], model.createData().joints
    for i in range(1, model.njoints):
        inertia, placement = model.inertias[i], model.jointPlacements[i]
        I = inertia.inertia  # noqa: E741
        body = bodies[model.parents[i]].add_body(
            pos=placement.translation,
            quat=pin.Quaternion(placement.rotation).coeffs()[[3, 0, 1, 2]],
            mass=inertia.mass,
            ipos=inertia.lever,
            fullinertia=[I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]],
            explicitinertial=True,
        )
        slide, turn = np.split(joints[i].S.ravel(), 2)
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slide.any() else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(type=kind, axis=slide + turn)
        bodies.append(body)
    arm = spec.compile()
    state, M = mujoco.MjData(arm), np.zeros((model.nv, model.nv))
    state.qpos[:] = np.linspace(-1.0, 1.0, model.nv)
    mujoco.mj_forward(arm, state)
    mujoco.mj_fullM(arm, state, M)
    expected = pin.crba(model, model.createData(), state.qpos, pin.Convention.WORLD)
    if not np.allclose(M, expected, rtol=1e-6, atol=1e-9):
        raise RuntimeError("MuJoCo's mass matrix differs from Pinocchio's")
    return arm


def mujoco_rollout(arm: Any, threads: int) -> Contender:
    """MuJoCo's own loop over steps and threads, which records every state."""
    import mujoco
    from mujoco.rollout import Rollout

    pool, data = Rollout(nthread=threads), [mujoco.MjData(arm) for _ in range(threads)]
    size = mujoco.mj_stateSize(arm, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros((PATHS, size))
    start[:, 1 : 1 + arm.nq] = np.random.default_rng(0).uniform(-0.3, 0.3, (PATHS, arm.nq))

    def run(ticks: int) -> None:
        pool.rollout(arm, data, start, nstep=ticks)

    return Contender("MuJoCo", threads, run, PATHS)
