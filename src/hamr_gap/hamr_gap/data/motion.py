"""How the joints moved, as far as any of their sensors says."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial
from scipy.integrate import cumulative_trapezoid

from hamr_dynamics.machine import Machine

from .record import Record


def coordinates(machine: Machine, record: Record) -> np.ndarray:
    """(n, joints) coordinates: as read, or integrals of rates or accelerations; zero where nobody looks, NaN where a sensor says nothing.

    An integral begins at zero in each stretch. Of a joint with a spring, which holds it somewhere, nothing is left of what a bias of the
    sensor and an unknown beginning add: a line, of accelerations a parabola.
    """
    found = np.zeros((len(record), len(machine.joints)))
    for j, (c, order) in measured_by(machine, record).items():
        found[:, j] = record.readings[:, c]
        spring = float(machine.diagonal(machine.at_rest.stiffness, j)) != 0.0
        for start, stop in record.stretches if order else ():
            found[start:stop, j] = _integral(found[start:stop, j], order, record.step, held=spring)
    return found


def measured_by(machine: Machine, record: Record) -> dict[int, tuple[int, int]]:
    """Joint -> the record's channel that says most directly where it was, and how often that is the coordinate's derivative."""
    found: dict[int, tuple[int, int]] = {}
    for c, channel in enumerate(record.channels):
        if (joint := machine.motion_of(channel)) and joint[1] < found.get(joint[0], (0, np.inf))[1]:
            found[joint[0]] = (c, joint[1])
    return found


def _integral(x: np.ndarray, order: int, step: float, *, held: bool) -> np.ndarray:
    """(n,) of (n,), over gaps straight on."""
    known, at = np.isfinite(x), np.arange(len(x))
    if known.sum() <= order + 1:
        return np.full(len(x), np.nan)
    total = np.interp(at, at[known], x[known])
    for _ in range(order):
        total = cumulative_trapezoid(total, dx=step, initial=0.0)
    if held:
        total = total - polynomial.polyval(at / len(x), polynomial.polyfit(at[known] / len(x), total[known], order))
    return np.where(known, total, np.nan)
