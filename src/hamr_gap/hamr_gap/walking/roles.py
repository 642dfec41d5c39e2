"""Which segments serve what: fit, select, calibrate and report, in turns that are never mixed."""

from __future__ import annotations

import numpy as np

from hamr_description.errors import BagError

from .segments import Segments

TURN_MS = 500.0  # in which segments serve one role
TURNS = ("fit", "select", "fit", "calibrate", "fit", "select", "fit", "report")
FITTED, JUDGED = 64, 64  # segments that are fitted, and that serve each other role, at most


def roles(whole: Segments) -> dict[str, np.ndarray]:
    """Role -> indices of segments, in turns of `TURN_MS`.

    Raises:
        BagError: too short for every role to have its turn.
    """
    turn = ((whole.first - whole.first[0]) * whole.walk.step // TURN_MS).astype(int)
    name = np.array(TURNS)[turn % len(TURNS)]
    found = {role: np.flatnonzero(name == role) for role in dict.fromkeys(TURNS)}
    if not all(map(len, found.values())):
        need = len(TURNS) * TURN_MS / 1e3
        lasts = whole.walk.step * len(whole.walk.angles) / 1e3
        raise BagError(f"The walk lasts {lasts:.1f} s: too short to fit on some and judge on others; record {need:g} s or more.")
    return {role: _thinned(index, FITTED if role == "fit" else JUDGED) for role, index in found.items()}


def _thinned(index: np.ndarray, most: int) -> np.ndarray:
    """No more than so many, evenly."""
    return index[np.unique(np.linspace(0, len(index) - 1, min(len(index), most)).astype(int))]
