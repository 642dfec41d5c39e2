"""Intervals of fitted parameters that allow for model error and for residuals that are not white."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..fitting.fit import Fit
from ..fitting.linear import jacobian
from ..fitting.parameters import Free
from ..fitting.weighed import Weighed
from ..naming.hypothesis import residual
from .colour import correlation_time

NORMAL_95 = 1.96
TURNS = 2  # of finding out what makes up for what
STEP = 0.1  # standard deviations, by which each independent direction is moved
INSIDE = 1e-3  # of that, at least: between bounds on which some parameters lie


def intervals(weighed: Weighed, found: Fit) -> np.ndarray:
    """(P, 2) 95 % intervals in scales, within the bounds.

    Gauss-Newton covariance, the residual's mean square and its correlation time counting as noise: what the model does not explain is
    noise with the colour it has. Parameters that almost make up for each other are moved together by what is unsure of them, for moved
    one by one their curvature would be taken for knowledge. Of what makes the run diverge with the least change only the prior is known.
    """
    left = residual(weighed, found)[weighed.chosen.any(1)]
    inflation = max(1.0, float(np.nanmean(left**2))) * correlation_time(left)
    precision = inflation * np.concatenate([[f.sd**-2.0 for f in found.free], weighed.sensor_precision])
    n = len(found.free)
    derivatives = jacobian(weighed, found.free, found.x, found.run, found.sensors)
    derivatives[:, ~np.isfinite(derivatives).all(0)] = 0.0
    for _ in range(TURNS if n else 0):
        covariance = inflation * _inverse(derivatives.T @ derivatives + np.diag(precision))[:n, :n]
        if not np.isfinite(moved := _together(weighed, found, covariance)).all():
            break
        derivatives[:, :n] = moved
    covariance = inflation * _inverse(derivatives.T @ derivatives + np.diag(precision))
    half = NORMAL_95 * np.sqrt(np.diag(covariance)[:n])
    return within(found.free, found.x, half)


def within(free: Sequence[Free], x: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(P, 2) intervals of x (P,) that reach half (P,) to either side, but not beyond the bounds."""
    low, high = (np.array([getattr(f, name) for f in free]) for name in ("low", "high"))
    return np.stack([np.maximum(x - half, low), np.minimum(x + half, high)], 1)


def _inverse(hessian: np.ndarray) -> np.ndarray:
    scale = 1.0 / np.sqrt(np.diag(hessian))
    return np.linalg.pinv(hessian * scale[:, None] * scale, hermitian=True) * scale[:, None] * scale


def _together(weighed: Weighed, found: Fit, covariance: np.ndarray) -> np.ndarray:
    """(m, P) derivatives of the weighed readings from steps along the principal directions of a covariance (P, P)."""
    sd = np.sqrt(np.diag(covariance))
    size, direction = np.linalg.eigh(covariance / sd[:, None] / sd)
    steps = STEP * (direction * np.sqrt(np.maximum(size, 1e-12))).T * sd
    low, high = (np.array([getattr(f, name) for f in found.free]) - found.x for name in ("low", "high"))
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead, back = (np.nanmin(np.where(s > 0.0, high / s, low / s), axis=1) for s in (steps, -steps))
    steps *= np.where(ahead >= back, np.clip(ahead, INSIDE, 1.0), -np.clip(back, INSIDE, 1.0))[:, None]  # not beyond the bounds
    model = weighed.model
    runs = model.runs(found.free, found.x + steps, weighed.until)
    read = [weighed.vector(found.sensors.read(run, model.reading_step, model.starts)) for run in (found.run[: weighed.until], *runs)]
    return np.linalg.solve(steps, np.array(read[1:]) - read[0]).T
