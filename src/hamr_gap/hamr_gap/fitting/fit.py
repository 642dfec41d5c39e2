"""Output-error fits: free runs against readings, by Gauss-Newton steps.

Weak priors keep what the data cannot tell apart, such as the common scale of inertia, stiffness, damping and gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .descent import STEPS, TOLERANCE, Point, descend, point
from .parameters import Free
from .sensors import Sensors
from .weighed import Weighed

HALVINGS = 30  # of a start that diverges
ROUGH = 2.0  # of the noise of a reading: what a fit leaves, from which others are worth their time


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: parameters and their values in scales. sensors. run: (n, channels) free run without the sensors' part.
        reading: with it. cost: half sum of squares on the fitted readings, with priors.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    sensors: Sensors
    run: np.ndarray
    reading: np.ndarray
    cost: float


def fit(weighed: Weighed, free: Sequence[Free], x0: np.ndarray, *, steps: int = STEPS, tolerance: float = TOLERANCE) -> Fit:
    """Least squares over free parameters and sensors from a start strictly inside the bounds.

    Args:
        x0: (P,) in scales. steps: at most. tolerance: relative decrease of cost at which it ends.

    Raises:
        BagError: the model diverges under the record's drives.
    """
    return ended(weighed, descend(weighed.fitted, begun(weighed, free, x0), steps=steps, tolerance=tolerance))


def begun(weighed: Weighed, free: Sequence[Free], x0: np.ndarray) -> Point:
    """Where a fit begins, from which `descend` goes on with `weighed.fitted`: its start (P,), or if that diverges, half way back to where
    everything is off or usual, and again.

    Raises:
        BagError: the model diverges under the record's drives.
    """
    x, center = np.clip(x0, [f.low for f in free], [f.high for f in free]), np.array([f.center for f in free])
    part = weighed.fitted
    for _ in range(HALVINGS):
        run = part.model.runs(free, x, part.until)[0]
        if np.isfinite(run).all() and np.isfinite((at := point(part, free, x, run)).cost):
            return at
        x = center + 0.5 * (x - center)
    machine = weighed.model.machine.name
    raise BagError(f"The model of {machine} diverges under the recorded drives: check units and numbers of the model, or the drives.")


def ended(weighed: Weighed, at: Point) -> Fit:
    """The fit that ends at a point, with a run of the whole record."""
    model, sensors = weighed.model, weighed.sensors(at.s)
    run = model.runs(at.free, at.x)[0]
    return Fit(at.free, at.x, sensors, run, sensors.read(run, model.reading_step, model.starts), at.cost)


def explains(weighed: Weighed, reading: np.ndarray) -> bool:
    """Whether readings leave little more than the noise, so that no other start is worth its time."""
    return bool(weighed.missed(reading).max() < ROUGH)
