"""Gauss-Newton steps of an output-error fit, whose derivatives and trial steps are lanes of one call each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .corrected import Corrected
from .linear import jacobian
from .parameters import Free
from .weighed import Weighed

#: Shares of a Newton step, and of its curvature added to each direction where the straight way misleads: what is tried first, in a block of
#: lanes, and after it. More than all of a step, since in long valleys, as of what sticks and slips, the next one leads on the same way.
TRIALS = (
    (np.array([2.0, 1.0, 0.7, 0.4, 0.2]), np.array([1e-2, 0.1, 1.0])),
    (np.array([4.0, 0.1, 0.05, 0.02, 0.007]), np.array([1e-4, 1e-3, 10.0])),
)
STEPS, TOLERANCE = 40, 3e-4  # of a fit, unless asked otherwise: steps at most, and relative decrease of cost at which it ends
KEPT = 0.3  # of what derivatives promise: where a step gains so much, no others are tried
DELTAS = (1e-4, 1e-3, 5e-3, 2e-2)  # of derivatives, as `jacobian` has them: what sticks and slips looks rough from near by
FORESEEN = 0.01  # of the cost: if derivatives promise more than this and nothing is gained, larger ones are tried
LEAST = 0.05  # of half a sum of squares in units of the noise: no step is worth less


@dataclass(frozen=True)
class Point:
    """Where a fit is.

    Attributes:
        free, x: parameters and their values (P,) in scales. run: (n, channels) there, as far as a fit simulates.
        s: coefficients of the sensors. cost: half sum of squares on the fitted readings, with priors. steps: that led there.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    run: np.ndarray
    s: np.ndarray
    cost: float
    steps: int = 0


def point(weighed: Weighed, free: Sequence[Free], x: np.ndarray, run: np.ndarray) -> Point:
    """A point with its sensors."""
    doubt = weighed.doubt(weighed.vector(weighed.model.target) - weighed.vector(run))
    s, _ = weighed.solve_sensors(run, doubt=doubt)
    s, cost = weighed.solve_sensors(run, weighed.sensors(s).shift, doubt)
    return Point(tuple(free), x, run, s, cost + doubt * _prior(free, x))


def descend(weighed: Weighed, at: Point, *, steps: int = STEPS, tolerance: float = TOLERANCE) -> Point:
    """Where Gauss-Newton steps lead from a point.

    Args:
        steps: at most. tolerance: relative decrease of cost at which it ends.
    """
    model, free, delta = weighed.model, at.free, DELTAS[0]
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    target, n = weighed.vector(model.target), len(free)
    x, run, s, cost = at.x, at.run, at.s, at.cost
    runs = Corrected(weighed, free, x, run)
    taken = 0
    while taken < steps and n:
        taken += 1
        sensors = weighed.sensors(s)
        derivatives = jacobian(weighed, free, x, run, sensors, runs.near, delta=delta)
        residual = target - weighed.vector(sensors.read(run, model.reading_step, model.starts))
        doubt = weighed.doubt(residual)
        own = np.append(s[:-1], 0.0)  # the shift has no prior
        cost = 0.5 * float(residual @ residual + doubt * (weighed.sensor_precision @ own**2)) + doubt * _prior(free, x)
        precision = doubt * np.concatenate([sd**-2.0, weighed.sensor_precision])
        gradient = derivatives.T @ residual - precision * np.concatenate([x - center, s])
        hessian = derivatives.T @ derivatives + np.diag(precision + 1e-9 * len(residual))
        direction = _bounded_step(hessian, gradient, x, low, high, n)
        foreseen = 0.5 * float(gradient @ direction)
        if foreseen < tolerance * cost or foreseen < LEAST:
            break
        left, at, there = np.inf, x, run
        for shares, curved in TRIALS:
            damped = [_bounded_step(hessian + np.diag(share * np.diag(hessian)), gradient, x, low, high, n)[:n] for share in curved]
            trials = np.clip(x + np.vstack([shares[:, None] * direction[:n], damped]), low, high)
            best = _best(weighed, free, runs, sensors.shift, doubt, trials)
            left, at, there = min((left, at, there), best, key=lambda trial: trial[0])
            if cost - left >= KEPT * foreseen:
                break
        promised, gained = left < cost, 0.0
        if promised:
            there = runs.at(at, there)
            solution, left = weighed.solve_sensors(there, sensors.shift, doubt)
            left += doubt * _prior(free, at)
            gained = max(0.0, cost - left)
        if gained > 0.0:
            x, run, s, cost = at, there, solution, left
        elif promised and not runs.exact:
            runs.refine()
            continue
        if gained < tolerance * cost or gained < LEAST:
            if foreseen < FORESEEN * cost or delta == DELTAS[-1]:
                break
            delta = DELTAS[DELTAS.index(delta) + 1]
    return Point(free, x, run, s, cost, taken)


def _best(
    weighed: Weighed, free: Sequence[Free], runs: Corrected, shift: float, doubt: float, trials: np.ndarray,
) -> tuple[float, np.ndarray, np.ndarray]:  # fmt: skip
    """Of (K, P) trials the one that costs least: its cost, (P,) itself, and its run."""
    tried = runs.near(trials)
    costs = np.full(len(trials), np.inf)
    for k in np.flatnonzero(np.isfinite(tried).all((1, 2))):
        costs[k] = weighed.solve_sensors(tried[k], shift, doubt)[1] + doubt * _prior(free, trials[k])
    k = int(np.argmin(costs))
    return float(costs[k]), trials[k], tried[k]


def _prior(free: Sequence[Free], x: np.ndarray) -> float:
    center, sd = (np.array([getattr(f, name) for f in free]) for name in ("center", "sd"))
    return 0.5 * float(np.sum(((x - center) / sd) ** 2))


def _bounded_step(hessian, gradient, x, low, high, n: int) -> np.ndarray:
    """Newton step that does not push parameters further that already sit on a bound."""
    held = np.zeros(len(gradient), bool)
    for _ in range(n + 1):
        free = ~held
        step = np.zeros(len(gradient))
        scale = 1.0 / np.sqrt(np.diag(hessian)[free])
        scaled = hessian[np.ix_(free, free)] * scale[:, None] * scale
        step[free] = scale * np.linalg.solve(scaled + 1e-12 * np.eye(len(scaled)), scale * gradient[free])
        pushing = np.zeros(len(gradient), bool)
        pushing[:n] = ((x <= low) & (step[:n] < 0)) | ((x >= high) & (step[:n] > 0))
        if not (pushing & ~held).any():
            break
        held |= pushing
    return step
