"""Derivatives of what a record would read with respect to free numbers, by differences in lanes of one call."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .parameters import Free
from .sensors import Sensors
from .weighed import Weighed


def jacobian(
    weighed: Weighed, free: Sequence[Free], x: np.ndarray, run: np.ndarray, sensors: Sensors,
    runs: Callable[[np.ndarray], np.ndarray] | None = None, *, delta: float = 1e-4,
) -> np.ndarray:  # fmt: skip
    """(m, P + sensors) derivatives of the weighed readings that count: free numbers first, then the sensors' part.

    Args:
        x: (P,) in scales. run: (n, channels) at x, n at least `weighed.until`. sensors: what reads it.
        runs: (K, P) -> (K, n, channels) that `run` is one of; the model's own if not given.
        delta: step of the differences, in standard deviations of a parameter's prior, or its scale where that is narrower.
    """
    model = weighed.model
    step = delta * np.minimum([f.sd for f in free], 1.0)
    step = np.where(x + step > [f.high for f in free], -step, step)

    def read(run: np.ndarray) -> np.ndarray:
        return weighed.vector(sensors.read(run, model.reading_step, model.starts))

    at = x + np.diag(step)
    probes = (runs(at) if runs else model.runs(free, at, len(run))) if len(free) else ()
    base = read(run)
    columns = [(read(p) - base) / d for p, d in zip(probes, step, strict=True)]
    return np.column_stack([*columns, weighed.sensor_columns(weighed.moved(run, sensors.shift))])
