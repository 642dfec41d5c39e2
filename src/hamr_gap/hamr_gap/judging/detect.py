"""The smallest effect that a record would have shown."""

from __future__ import annotations

import numpy as np

from hamr_dynamics.effects.law import Scales
from hamr_dynamics.effects.library import find
from hamr_dynamics.machine import Machine

from ..data.si import si_of
from ..naming.screen import Screen

SEEN = 40.0  # half squared distance in units of noise at which an effect stands out among all that were tried


def detectable(machine: Machine, scales: Scales, seen: Screen, *, least: float = 0.0) -> dict[str, dict[str, str]]:
    """effect -> joint (or both) -> size with unit, for forms of one size: its response after a re-tune, against the noise.

    Args:
        least: half squared distance below which a gap is none whatever its significance.
    """
    gram, _, _ = seen.fitted
    fixed = slice(0, seen.fixed)
    inner = gram[fixed, fixed] + np.diag(seen.ridge[fixed])
    scale = 1.0 / np.sqrt(np.diag(inner))
    inner = inner * scale[:, None] * scale + 1e-10 * np.eye(seen.fixed)
    found: dict[str, dict[str, str]] = {}
    enough = max(SEEN, least)
    for (effect, form, place), options in seen.groups.items():
        at = "both" if find(effect, form).acts == "pair" else machine.joints[place]
        if any(len(option) > 1 for option in options) or at in found.get(effect, {}):
            continue  # the simplest form stands for the name
        size = np.inf
        for (column,) in options:
            c = seen.fixed + column
            across = gram[fixed, c] * scale
            left = gram[c, c] - across @ np.linalg.solve(inner, across)
            if left > 1e-9 * gram[c, c] > 0:
                size = min(size, np.sqrt(2.0 * enough / left) * seen.columns[column].size)
        if np.isfinite(size):
            dimension = seen.columns[options[0][0]].parameter.dimension
            factor, unit = si_of(dimension, machine)
            said = f"{size * scales.of(dimension) * factor:.2g} {unit}".removesuffix(" 1")
            found.setdefault(effect, {}).setdefault(at, said)
    return found
