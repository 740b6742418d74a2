"""Which frame of an arm is its tip: the default of its tool."""

import numpy as np

from ftcfa.model.arm import Arm

TIE_DIGITS = 9
"""Decimals to which distances along the links are compared, so to a nanometre."""


def tip(arm: Arm) -> str:
    """Name of the frame that most joints move; of several, the one farthest down the chain."""
    tree = arm.tree()
    lengths = np.linalg.norm(tree.translations, axis=1)

    def reach(name: str) -> tuple[int, float]:
        frame = tree.frames[name]
        joints = tree.joints_above(frame)
        moving = sum(bool(arm.G[j].any()) for j in joints)
        length = np.linalg.norm(frame.translation) + sum(lengths[j] for j in joints)
        return moving, round(float(length), TIE_DIGITS)

    return max(reversed(tuple(tree.frames)), key=reach)
