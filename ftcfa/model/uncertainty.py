"""Uncertain robots: a distribution of possible robots around a nominal arm."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, known_name, natural, vector
from ftcfa.errors import ParameterError
from ftcfa.model.arm import Arm
from ftcfa.model.inertia import (
    changed_pseudo_inertia,
    check_spread,
    inertial_parameters,
    pseudo_inertia,
    symmetric,
)
from ftcfa.model.pinocchio_model import BodyFrame
from ftcfa.model.tip import tip
from ftcfa.parts import Part
from ftcfa.portable import exp, normal_cdf, product
from ftcfa.streams import ROBOT, Words, normals_of_paths

Distribution = Literal["log-normal", "bounded"]
DEVIATES = 12
"""Number of deviates of a joint and its body: mass, centre (3), strains (3), shears (3), damping
and Coulomb friction; one for each rotor follows."""
STRAIN_DEVIATIONS = [1.0, 1.0, 1.0, *3 * [np.sqrt(0.5)]]
"""Standard deviations of strains and shears for a spread of one."""
FRICTION_DEVIATES = {"damping": 10, "friction": 11}
CHUNK = 512
"""Number of robots drawn at once, which fit into the processor's cache."""


def check_payload(subject: str, payload: tuple[float, float], unit: str) -> None:
    """Raise a FtcfaError unless a payload is two masses, the smaller one first."""
    low, high = vector(subject, payload, 2).tolist()
    if not 0 <= low <= high:
        got = f"({low:g}, {high:g})"
        raise ParameterError(subject, got, f"0 <= smallest <= largest [{unit}]")


@dataclass(frozen=True)
class Uncertainty(Part):
    """A distribution of possible robots around a nominal arm; without arguments, it is certain.

    Every body is drawn independently. With the ``"log-normal"`` distribution n is a standard normal
    deviate; with the ``"bounded"`` one it is uniform on [-1, 1]:

        mass      m -> m exp(s n)  or  m (1 + s n)
        centre    c -> c + s n, for each coordinate
        shape     x - c -> exp(E) (x - c),   E_ii = s n,   E_ij = E_ji = s n / sqrt(2)
        friction  as the mass, for damping and Coulomb friction of every joint
        armature  as the mass, for the rotor inertia of every joint

    The inertia of a draw is that of the deformed body, so every draw is a possible robot, and mass,
    centre and inertia are correlated as in a body (`changed_pseudo_inertia`). The normal strain of
    ``"log-normal"`` has the same distribution along every direction. Massless bodies do not change.

    Attributes:
        mass: Relative spread s of the mass.
        centre: Spread of the centre of mass [m].
        shape: Spread of the strain of each body's distribution of mass.
        friction: Relative spread of damping and Coulomb friction.
        armature: Relative spread of the rotor inertias.
        payload: Smallest and largest mass of a point mass, uniform in between [kg]; None for none.
        payload_frame: Link or joint that carries the payload. By default it is the tip: of the
            frames that the most joints move, the one with the longest distance from the base along
            the links; of several such frames, the last in the URDF.
        payload_offset: Position of the payload in that frame, shape (3,) [m].
        distribution: ``"log-normal"`` or ``"bounded"``.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If a field has a wrong range, shape or name.
    """

    mass: Annotated[float, Check(check_spread)] = 0.0
    centre: Annotated[float, Check(check_spread, "m")] = 0.0
    shape: Annotated[float, Check(check_spread)] = 0.0
    friction: Annotated[float, Check(check_spread)] = 0.0
    armature: Annotated[float, Check(check_spread)] = 0.0
    payload: Annotated[tuple[float, float] | None, Check(check_payload, "kg")] = None
    payload_frame: str | None = None
    payload_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distribution: Distribution = "log-normal"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("mass", "friction", "armature"):
            if self.distribution == "bounded" and getattr(self, name) >= 1:
                subject, got = f"Uncertainty {name}", repr(getattr(self, name))
                remedy = 'take distribution="log-normal" for larger spreads'
                raise ParameterError(subject, got, "a number below 1", remedy, field=name)
        subject = "Uncertainty payload_offset"
        offset = vector(subject, self.payload_offset, 3, field="payload_offset").tolist()
        object.__setattr__(self, "payload_offset", tuple(offset))
        if self.payload is not None:
            low, high = vector("Uncertainty payload", self.payload, 2).tolist()
            object.__setattr__(self, "payload", (low, high))
        elif self.payload_frame is not None or any(offset):
            subject = "Uncertainty payload_frame and payload_offset"
            remedy = "give payload=(smallest, largest)"
            raise ParameterError(subject, "no payload", "a payload", remedy, field="payload")

    def draw(self, arm: Arm, seed: int, paths: Iterable[int]) -> dict[str, Array]:
        """Parameters of the robots of some paths, by their names in `Arm.varies`.

        The robot of a path depends on (seed, path) alone: it is the same whichever others are
        drawn, and each spread changes its own quantity alone.

        Args:
            arm: The nominal arm.
            seed: Seed of the experiment, 0 <= seed < 2^64.
            paths: Numbers of the paths, 0 <= path < 2^64.

        Returns:
            ``inertias``, shape (paths, N, 10), and, where ``friction`` is uncertain and the arm has
            it, ``damping`` and ``friction``, shape (paths, N); likewise ``armature``.

        Raises:
            UnknownNameError, ParameterError: As in `check`, or if a seed or path is out of range.
        """
        self.check(arm)
        seed = natural("seed", seed)
        numbers = np.array([natural("path", path) for path in paths], dtype=np.uint64)
        starts = range(0, max(1, len(numbers)), CHUNK)
        chunks = [self._draw(arm, seed, numbers[i : i + CHUNK]) for i in starts]
        return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in chunks[0]}

    def robot(self, arm: Arm, seed: int, path: int) -> Arm:
        """The robot of one path; see `draw`."""
        drawn = {name: values[0] for name, values in self.draw(arm, seed, [path]).items()}
        arm = arm.with_inertias(drawn.pop("inertias"))
        if "armature" in drawn:
            arm = arm.with_armature(drawn.pop("armature"))
        return arm.with_joint_friction(**drawn)

    def check(self, arm: Arm) -> None:
        """Raise unless an arm has every uncertain quantity.

        Raises:
            UnknownNameError: If the arm has no frame ``payload_frame``; it lists those it has.
            ParameterError: If it is no Arm, if no joint moves the frame, or if it has no friction.
        """
        if not isinstance(arm, Arm):
            expected = "an Arm, such as load_arm gives"
            raise ParameterError("uncertain robot", f"a {type(arm).__name__}", expected)
        if self.friction > 0 and not _friction_of(arm):
            subject = f"uncertain friction of {arm.name}"
            expected = "an arm with damping or Coulomb friction"
            remedy = "write <dynamics> into its URDF, or leave friction out"
            raise ParameterError(subject, "no friction", expected, remedy, field="friction")
        if self.armature > 0 and not arm.armature.any():
            subject, remedy = f"uncertain armature of {arm.name}", "pass armature to load_arm"
            expected = "an arm with rotor inertias"
            raise ParameterError(subject, "no armature", expected, remedy, field="armature")
        if self.payload is not None:
            self._carrier(arm)

    def _carrier(self, arm: Arm) -> BodyFrame:
        """Frame that carries the payload."""
        tree = arm.tree()
        if self.payload_frame is None:
            return tree.frames[arm.tool]
        name, field = self.payload_frame, "payload_frame"
        known_name(f"{field} of {arm.name}", name, tree.frames, field=field)
        frame = tree.frames[name]
        if not any(arm.G[j].any() for j in tree.joints_above(frame)):
            got = "a frame that no joint moves"
            expected = f"one that carries its payload, such as '{tip(arm)}'"
            raise ParameterError(f"{field} '{name}' of {arm.name}", got, expected, field=field)
        return frame

    def _draw(self, arm: Arm, seed: int, paths: Words) -> dict[str, Array]:
        N = len(arm.g0)
        rotors = N if self.armature > 0 else 0
        normals = normals_of_paths(seed, paths, ROBOT, 1 + DEVIATES * N + rotors)
        all_n = normals[:, 1:] if self.distribution == "log-normal" else _uniform(normals[:, 1:])
        n = all_n[:, : DEVIATES * N].reshape(len(paths), N, DEVIATES)
        J = changed_pseudo_inertia(
            pseudo_inertia(arm.inertias),
            self._factor(self.mass, n[..., 0]),
            self.centre * n[..., 1:4],
            self.shape * symmetric(*np.moveaxis(n[..., 4:10] * STRAIN_DEVIATIONS, -1, 0)),
        )
        if self.payload is not None:
            low, high = self.payload
            joint, rotation, translation = self._carrier(arm)
            offset = product(rotation, np.reshape(self.payload_offset, (3, 1)))[:, 0]
            x = np.append(translation + offset, 1.0)
            load = low + (high - low) * normal_cdf(normals[:, 0])
            J[:, joint] += load[:, None, None] * np.outer(x, x)
        drawn = {"inertias": inertial_parameters(J)}
        if self.friction > 0:
            for name, nominal in _friction_of(arm).items():
                deviates = n[..., FRICTION_DEVIATES[name]]
                drawn[name] = nominal * self._factor(self.friction, deviates)
        if self.armature > 0:
            factor = self._factor(self.armature, all_n[:, DEVIATES * N :])
            drawn["armature"] = arm.armature * factor
        return drawn

    def _factor(self, spread: float, n: Array) -> Array:
        return exp(spread * n) if self.distribution == "log-normal" else 1.0 + spread * n


def _uniform(n: Array) -> Array:
    """Uniform deviates on [-1, 1] of normal ones."""
    return 2.0 * normal_cdf(n) - 1.0


def _friction_of(arm: Arm) -> dict[str, Array]:
    """Damping and Coulomb friction by name, if a moving joint has them."""
    moving = arm.G.any(axis=1)
    both = {"damping": arm.damping, "friction": arm.friction}
    return {name: values for name, values in both.items() if values[moving].any()}
