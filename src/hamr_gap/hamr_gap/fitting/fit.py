"""Output-error fits: free runs against readings, by Gauss-Newton steps.

Weak priors keep what the data cannot tell apart, such as the common scale of inertia, stiffness, damping and gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .descent import Point, descend, point
from .parameters import Free
from .sensors import Sensors
from .weighed import Weighed

HALVINGS = 30  # of a start that diverges
ROUGH = 2.0  # of the noise of a reading: what a fit leaves, from which another start is worth its time


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: parameters and their values in scales. sensors. run: (n, channels) free run without the sensors' part.
        reading: with it. cost: half sum of squares on the fitted readings, with priors. steps: that it took.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    sensors: Sensors
    run: np.ndarray
    reading: np.ndarray
    cost: float
    steps: int = 0


def fit(weighed: Weighed, free: Sequence[Free], x0: np.ndarray, *, steps: int = 40, tolerance: float = 3e-4) -> Fit:
    """Least squares over free parameters and sensors from a start strictly inside the bounds.

    Args:
        x0: (P,) in scales. steps: at most. tolerance: relative decrease of cost at which it ends.

    Raises:
        BagError: the model diverges under the record's drives.
    """
    model = weighed.model
    at = _started(weighed.fitted, free, np.clip(x0, [f.low for f in free], [f.high for f in free]))
    at = descend(weighed.fitted, free, at, steps=steps, tolerance=tolerance)
    sensors, run = weighed.sensors(at.s), model.runs(free, at.x)[0]
    return Fit(tuple(free), at.x, sensors, run, sensors.read(run, model.reading_step, model.starts), at.cost, at.steps)


def _started(weighed: Weighed, free: Sequence[Free], x: np.ndarray) -> Point:
    """A start that does not diverge: of one too bold, half way back to where everything is off or usual, and again."""
    center = np.array([f.center for f in free])
    for _ in range(HALVINGS):
        run = weighed.model.runs(free, x, weighed.until)[0]
        if np.isfinite(run).all():
            return point(weighed, free, x, run)
        x = center + 0.5 * (x - center)
    machine = weighed.model.machine.name
    raise BagError(f"The model of {machine} diverges under the recorded drives: check units and numbers of the model, or the drives.")
