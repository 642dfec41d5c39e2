"""The front-left leg's vectors and tensors, mirrored to the other legs (signs of names.MIRROR)."""

from __future__ import annotations

import numpy as np

from .names import MIRROR


def point(leg: str, xyz) -> np.ndarray:
    """A point or a true vector (3,), any unit."""
    sx, sy = MIRROR[leg]
    return np.asarray(xyz, float) * (sx, sy, 1)


def inertia(leg: str, tensor) -> np.ndarray:
    """An inertia tensor [ixx, iyy, izz, ixy, ixz, iyz] (6,): only products change sign."""
    sx, sy = MIRROR[leg]
    return np.asarray(tensor, float) * (1, 1, 1, sx * sy, sx, sy)


def end(leg: str) -> str:
    """The leg's end of the robot, `front` or `rear`: which constants it takes where the two differ."""
    return "front" if leg.startswith("f") else "rear"
