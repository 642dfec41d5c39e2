"""The smallest effect that a record would have shown."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine

from ..data.si import si_of
from ..fitting.parameters import Candidate
from ..naming.screen import Screen

SEEN = 40.0  # half squared distance in units of noise at which an effect stands out among all that were tried


def detectable(
    machine: Machine, scales: Scales, seen: Screen, wanted: Iterable[Candidate], *, least: float = 0.0
) -> dict[str, dict[str, str]]:
    """effect -> joint (or both) -> size with unit, of its response after a re-tune against the noise; of what would not be seen even if it
    were as large as is looked for, "more than" that.

    Args:
        wanted: forms of one size (`of_one_size`), each at one joint or between two, that were seen.
        least: half squared distance below which a gap is none whatever its significance.
    """
    gram, _, _ = seen.fitted
    fixed = slice(0, seen.fixed)
    inner = gram[fixed, fixed] + np.diag(seen.ridge[fixed])
    scale = 1.0 / np.sqrt(np.diag(inner))
    inner = inner * scale[:, None] * scale + 1e-10 * np.eye(seen.fixed)
    found: dict[str, dict[str, str]] = {}
    enough = max(SEEN, least)
    for candidate in wanted:
        size = np.inf
        for (column,) in seen.options(candidate):
            c = seen.fixed + column
            across = gram[fixed, c] * scale
            left = gram[c, c] - across @ np.linalg.solve(inner, across)
            if left > 1e-9 * gram[c, c] > 0:
                size = min(size, np.sqrt(2.0 * enough / left) * seen.columns[column].size)
        if np.isfinite(size):
            parameter = candidate.law.sizes[0]
            factor, unit = si_of(parameter.dimension, machine)
            at = "both" if candidate.law.acts == "pair" else machine.joints[candidate.joints[0]]
            largest = max(-parameter.low, parameter.high)
            said = f"{min(size, largest) * scales.of(parameter.dimension) * factor:.2g} {unit}".removesuffix(" 1")
            said = f"more than {said}" if size > largest else said
            found.setdefault(candidate.effect, {})[at] = said
    return found
