"""Forces on a Pinocchio model's joints for which Pinocchio has no function of its own."""

import numpy as np
import pinocchio as pin

from ftcfa.arrays import Array


def torque_regressor(
    model: pin.Model, data: pin.Data, q: Array, v_sum: Array, v_difference: Array, a_r: Array
) -> Array:
    """Y with Y p = M a_r + C(q, v) v_r + h for the inertial parameters p, shape (N, 10 N).

    C v_r is bilinear and symmetric in v and v_r (Christoffel's C). It is therefore a quarter of
    the difference between C v at v + v_r and C v at v - v_r.

    Args:
        model: The model.
        data: Work space of the model.
        q: Position, shape (N,) [rad or m].
        v_sum: v + v_r, shape (N,) [rad/s or m/s].
        v_difference: v - v_r, shape (N,) [rad/s or m/s].
        a_r: Reference acceleration, shape (N,) [rad/s^2 or m/s^2].
    """
    zero = np.zeros(model.nv)

    def regressor(v: Array, a: Array) -> Array:
        return np.array(pin.computeJointTorqueRegressor(model, data, q, v, a))

    return regressor(zero, a_r) + (regressor(v_sum, zero) - regressor(v_difference, zero)) / 4.0


def base_coupling(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """M_qb(q) of the model's joints, shape (N, 6); see `Arm.base_coupling`.

    Taken from the centroidal momentum matrix, shifted from the centre of mass to the base origin.
    """
    A = pin.computeCentroidalMap(model, data, q)
    A = A.reshape(6, -1)  # for a single joint Pinocchio drops the second dimension
    linear, angular = A[:3], A[3:] + pin.skew(data.com[0]) @ A[:3]
    return np.vstack([linear, angular]).T


class TurningBase:
    """The joints and bodies of a model on a base that is free to move, without gravity."""

    def __init__(self, model: pin.Model) -> None:
        free = pin.Model()
        free.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
        for i in range(1, model.njoints):
            parent = model.parents[i] + 1
            free.addJoint(parent, model.joints[i], model.jointPlacements[i], model.names[i])
            free.appendBodyToJoint(i + 1, model.inertias[i], pin.SE3.Identity())
        free.gravity.linear = np.zeros(3)
        self._model, self._data = free, free.createData()

    def force(self, q: Array, v: Array, omega: Array) -> Array:
        """Difference that omega makes to C v, shape (N,); see `Arm.base_rotation_force`."""
        at = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], q])
        turning, still = np.concatenate([np.zeros(3), omega, v]), np.concatenate([np.zeros(6), v])
        force = pin.nonLinearEffects(self._model, self._data, at, turning)[6:].copy()
        return force - pin.nonLinearEffects(self._model, self._data, at, still)[6:]
