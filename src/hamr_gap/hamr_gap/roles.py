"""Which samples serve what: fit, select, calibrate and report, never mixed, with dead time between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .model import Model

SHARES = {"fit": 0.5, "select": 0.25, "calibrate": 0.1, "report": 0.15}
DEAD_S = 0.5  # between roles, less where a whole record is short
DEAD_SHARE = 0.05


@dataclass(frozen=True, slots=True)
class Roles:
    """Slices of the averaged readings of a record."""

    fit: slice
    select: slice
    calibrate: slice
    report: slice


def roles_of(model: Model, seconds_per_t: float) -> Roles:
    """Four parts of a record in order of time; the first readings, in which an unknown start is forgotten, belong to none.

    Raises:
        BagError: too short to be divided.
    """
    n = len(model.target)
    dead = int(min(DEAD_S / seconds_per_t / model.reading_step, DEAD_SHARE * n))
    begin = dead if not model.record.rest else min(dead // 4, n)
    useful = n - begin - 3 * dead
    if useful < 80:
        raise BagError(f"The record has {n} readings: too few to fit on some and judge on others; record longer.")
    cuts, at = {}, begin
    for name, share in SHARES.items():
        stop = at + int(share * useful)
        cuts[name] = slice(at, stop)
        at = stop + dead
    return Roles(**cuts)


def mask(model: Model, part: slice) -> np.ndarray:
    """(n, channels) True where a reading of a part exists."""
    chosen = np.zeros(model.target.shape, bool)
    chosen[part] = True
    return chosen & np.isfinite(model.target)
