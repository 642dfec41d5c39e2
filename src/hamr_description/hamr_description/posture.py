"""The robot at rest, from the joint origins of the lift chain."""

from __future__ import annotations

import numpy as np

from . import mirror
from .numbers import leg_value


def neutral_foot(leg: str) -> np.ndarray:
    """Foot in the chassis frame at rest (3,), mm."""
    chain = sum(leg_value(leg, f"origins.{joint}") for joint in ("lift_slider", "l1", "l2", "fb3"))
    return mirror.point(leg, chain + leg_value(leg, "foot_in_L4"))


def stand_height() -> float:
    """Height of the chassis frame with neutral feet just touching the ground, mm."""
    return -float(neutral_foot("fl")[2])


def hang_height() -> float:
    """Height of the chassis frame when suspended, mm: twice as high, so that no leg reaches the ground."""
    return 2 * stand_height()
