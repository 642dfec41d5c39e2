"""Gymnasium spaces of observations and actions."""

from __future__ import annotations

import numpy as np
from gymnasium import spaces

from hamr_description.names import JOINTS

from .observation import components


def observation_space(view: str) -> spaces.Box:
    """Unbounded, (size,) float32 in the units of `observation.components`."""
    return spaces.Box(-np.inf, np.inf, (len(components(view)),), np.float32)


def action_space() -> spaces.Box:
    """Target hip angles in canonical joint order, (8,) float32; 1 is `controller.target_limit`."""
    return spaces.Box(-1.0, 1.0, (len(JOINTS),), np.float32)
