"""Chains of revolute joints as URDFs, for arms of any number of joints."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np


def write_chain(n: int, file: Path) -> None:
    """Write the URDF of n revolute joints in a row: random axes, physical inertias."""
    rng = np.random.default_rng(n)
    parts = ['<robot name="chain"><link name="link0"/>']
    for i in range(1, n + 1):
        mass = 4.0 * 0.85**i
        spread = mass * rng.uniform(0.002, 0.01, 3)  # second moments of mass about the centre
        xx, yy, zz = spread.sum() - spread
        axis, xyz, rpy, centre, turn = (_row(rng.uniform(-s, s, 3)) for s in (1, 0.15, 1, 0.15, 1))
        parts.append(
            f'<joint name="joint{i}" type="revolute">'
            f'<parent link="link{i - 1}"/><child link="link{i}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" velocity="10" effort="{200 * 0.9**i + 5}"/></joint>'
            f'<link name="link{i}"><inertial><origin xyz="{centre}" rpy="{turn}"/>'
            f'<mass value="{mass}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
            "</inertial></link>"
        )
    file.write_text("".join([*parts, "</robot>"]))


def _row(numbers: Iterable[float]) -> str:
    """Numbers as a URDF writes them."""
    return " ".join(f"{x:.6f}" for x in numbers)
