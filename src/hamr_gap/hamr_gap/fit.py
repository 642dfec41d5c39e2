"""Output-error fits: free runs against readings, by Gauss-Newton steps whose derivatives and trial steps are lanes of one call.

Weak priors keep what the data cannot tell apart, such as the common scale of inertia, stiffness, damping and gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .linear import jacobian
from .parameters import Free
from .sensors import Sensors
from .weighed import Weighed

#: Shares of a Newton step; more than all of it, since in long valleys, as of what sticks and slips, the next one leads on the same way.
TRIALS = np.array([4.0, 2.0, 1.0, 0.7, 0.4, 0.2, 0.1, 0.05, 0.02, 0.007])
DAMPED = np.array([1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0])  # shares of its curvature added to each direction, where the straight way misleads
DELTAS = (1e-3, 5e-3, 2e-2)  # of derivatives, as `jacobian` has them: what sticks and slips looks rough from near by
FORESEEN = 0.01  # of the cost: if derivatives promise more than this and nothing is gained, larger ones are tried
HALVINGS = 30  # of a start that diverges


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: parameters and their values in scales. sensors. run: (n, channels) free run without the sensors' part.
        reading: with it. cost: half sum of squares on the fitted readings, with priors. converged: whether it ended by itself.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    sensors: Sensors
    run: np.ndarray
    reading: np.ndarray
    cost: float
    converged: bool


def fit(weighed: Weighed, free: Sequence[Free], x0: np.ndarray, *, steps: int = 40, tolerance: float = 3e-4) -> Fit:
    """Least squares over free parameters and sensors from a start strictly inside the bounds.

    Args:
        x0: (P,) in scales. steps: at most. tolerance: relative decrease of cost at which it ends.

    Raises:
        BagError: the model diverges under the record's drives.
    """
    model, until = weighed.model, weighed.until
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    x, run = _started(weighed, free, np.clip(x0, low, high), center)
    target = weighed.vector(model.target)
    doubt = weighed.doubt(target - weighed.vector(run))
    s, _ = weighed.solve_sensors(run, doubt=doubt)
    s, cost = weighed.solve_sensors(run, weighed.sensors(s).shift, doubt)
    cost += doubt * _prior(x, center, sd)
    converged, delta = False, DELTAS[0]
    for _ in range(steps):
        sensors = weighed.sensors(s)
        derivatives = jacobian(weighed, free, x, run, sensors, delta=delta)
        residual = target - weighed.vector(sensors.read(run, model.reading_step, model.starts))
        doubt, n = weighed.doubt(residual), len(free)
        own = np.append(s[:-1], 0.0)  # the shift has no prior
        cost = 0.5 * float(residual @ residual + doubt * (weighed.sensor_precision @ own**2)) + doubt * _prior(x, center, sd)
        precision = doubt * np.concatenate([sd**-2.0, weighed.sensor_precision])
        gradient = derivatives.T @ residual - precision * np.concatenate([x - center, s])
        hessian = derivatives.T @ derivatives + np.diag(precision + 1e-9 * len(residual))
        direction = _bounded_step(hessian, gradient, x, low, high, n)
        if not n:
            break
        damped = [_bounded_step(hessian + np.diag(share * np.diag(hessian)), gradient, x, low, high, n) for share in DAMPED]
        trials = np.clip(x + np.vstack([TRIALS[:, None] * direction[:n], [d[:n] for d in damped]]), low, high)
        runs = model.runs(free, trials, until)
        finite = np.isfinite(runs).all((1, 2))
        costs, solutions = np.full(len(trials), np.inf), [None] * len(trials)
        for k in np.flatnonzero(finite):
            if k < len(TRIALS) and k > 1 and costs[k - 1] > costs[k - 2] and costs[k - 2] < cost:
                continue  # past the best
            solutions[k], left = weighed.solve_sensors(runs[k], sensors.shift, doubt)
            costs[k] = left + doubt * _prior(trials[k], center, sd)
        best, foreseen = int(np.argmin(costs)), 0.5 * float(gradient @ direction)
        gained = max(cost - costs[best], 0.0)
        if gained > 0.0:
            x, run, s, cost = trials[best], runs[best], solutions[best], float(costs[best])
        if gained < tolerance * cost or gained < 0.05:
            if foreseen < FORESEEN * cost or delta == DELTAS[-1]:
                converged = True
                break
            delta = DELTAS[DELTAS.index(delta) + 1]
    sensors, run = weighed.sensors(s), model.runs(free, x)[0]
    return Fit(tuple(free), x, sensors, run, sensors.read(run, model.reading_step, model.starts), cost, converged)


def _started(weighed: Weighed, free: Sequence[Free], x: np.ndarray, center: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A start that does not diverge, and its run: of one too bold, half way back to where everything is off or usual, and again."""
    for _ in range(HALVINGS):
        run = weighed.model.runs(free, x, weighed.until)[0]
        if np.isfinite(run).all():
            return x, run
        x = center + 0.5 * (x - center)
    machine = weighed.model.machine.name
    raise BagError(f"The model of {machine} diverges under the recorded drives: check units and numbers of the model, or the drives.")


def _prior(x: np.ndarray, center: np.ndarray, sd: np.ndarray) -> float:
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
