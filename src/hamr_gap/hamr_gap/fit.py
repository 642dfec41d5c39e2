"""Output-error fits: free runs against readings, by Gauss-Newton steps whose derivatives and trial steps are lanes of one call.

What sensors add linearly (bias of each channel, gain of each actuator sensor, one shift of all clocks) is solved together with
every step. Weak priors keep what the data cannot tell apart, such as the common scale of inertia, stiffness, damping and gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .model import Model
from .parameters import Free

TRIALS = np.array([1.0, 0.7, 0.5, 0.35, 0.25, 0.12, 0.06, 0.03, 0.015, 0.007])
DAMPED = np.array([1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0])  # shares of its curvature added to each direction, where the straight way misleads
GAIN_SD = 0.01  # of a sensor's scale, which calibration leaves uncertain by a per cent
DELTA = 1e-3  # of a parameter's prior, for differences


@dataclass(frozen=True)
class Sensors:
    """The linear part: reading = (1 + gain) y + bias - shift dy/dt.

    Attributes:
        bias, gain: (channels,). shift: T.
    """

    bias: np.ndarray
    gain: np.ndarray
    shift: float

    def read(self, y: np.ndarray, step: float, starts: Sequence[int] = ()) -> np.ndarray:
        """(n, channels) readings of a run (n, channels); from `starts` it starts as measured, so that there no shift moves it."""
        return (1.0 + self.gain) * y + self.bias - self.shift * slope(y, step, starts)


def slope(y: np.ndarray, step: float, starts: Sequence[int] = ()) -> np.ndarray:
    """(..., n, channels) time derivative of (..., n, channels), less what it is at the last of the starts before."""
    found = np.gradient(y, step, axis=-2)
    inside = [start for start in starts if start + 1 < y.shape[-2]]
    for start, stop in zip(inside, (*inside[1:], y.shape[-2]), strict=False):
        found[..., start:stop, :] -= (y[..., start + 1, :] - y[..., start, :])[..., None, :] / step
    return found


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: parameters and their values in scales. sensors. run: (n, channels) free run without the sensors' part.
        reading: with it. cost: half sum of squares on the fitted readings, with priors. jacobian: (m, P + sensors) weighted, of the
        fitted readings, scaled parameters first. hessian: of cost, with priors.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    sensors: Sensors
    run: np.ndarray
    reading: np.ndarray
    cost: float
    converged: bool


@dataclass(frozen=True)
class Weighed:
    """A model with the readings that count and their noise: what a fit is about.

    Attributes:
        coarse: the same model with as few steps as it bears, for the many runs of a screening; None for the model itself.
        chosen: (n, channels) readings that count. sigma: (channels,) noise of an averaged reading.
        gains: channels whose gain is free: all of two coupled joints; of one joint, where it is the drive's, those beside it.
    """

    model: Model
    chosen: np.ndarray
    sigma: np.ndarray
    gains: tuple[int, ...]
    coarse: Model | None = None

    @cached_property
    def until(self) -> int:
        """Readings up to the last that counts: further than that a fit need not simulate."""
        return int(np.flatnonzero(self.chosen.any(1))[-1]) + 1

    def vector(self, y: np.ndarray) -> np.ndarray:
        """Weighted readings that count, (m,), of (n, channels) or (K, m) of (K, n, channels), n at least `until`."""
        return (y[..., : self.until, :] / self.sigma)[..., self.chosen[: self.until]]

    @property
    def biased(self) -> tuple[int, ...]:
        """Channels whose bias is free: not those of joints that start as measured, each time anew."""
        joints = len(self.model.machine.joints) if self.model.starts else 0
        return tuple(c for c, own in enumerate(self.model.own) if own >= joints)

    @property
    def sensor_count(self) -> int:
        """Columns of `sensor_columns`."""
        return len(self.biased) + len(self.gains) + 1

    def sensor_columns(self, run: np.ndarray) -> np.ndarray:
        """(m, biases + gains + 1) derivatives of the weighted readings with respect to the sensors' part."""
        columns = []
        for c in self.biased:
            bias = np.zeros_like(run)
            bias[:, c] = self.sigma[c]  # in units of noise, so that columns are alike in size
            columns.append(bias)
        for c in self.gains:
            gain = np.zeros_like(run)
            gain[:, c] = run[:, c]
            columns.append(gain)
        columns.append(-slope(run, self.model.reading_step, self.model.starts) * self.model.reading_step)
        return self.vector(np.stack(columns)).T

    @cached_property
    def sensor_precision(self) -> np.ndarray:
        """Prior precision of the coefficients of `sensor_columns`: a sensor's scale is known to a per cent, the rest is not."""
        precision = np.full(self.sensor_count, 1e-9)
        precision[len(self.biased) : -1] = GAIN_SD**-2.0
        return precision

    def sensors(self, s: np.ndarray) -> Sensors:
        """Sensors of the coefficients of `sensor_columns`."""
        bias, gain = np.zeros(len(self.sigma)), np.zeros(len(self.sigma))
        biased, gains = list(self.biased), list(self.gains)
        bias[biased] = s[: len(biased)] * self.sigma[biased]
        gain[gains] = s[len(biased) : -1]
        return Sensors(bias, gain, float(s[-1]) * self.model.reading_step)

    def solve_sensors(self, run: np.ndarray) -> tuple[np.ndarray, float]:
        """Best sensor coefficients for a run, and the half sum of squares that is left."""
        columns = self.sensor_columns(run)
        residual = self.vector(self.model.target[: len(run)] - run)
        s = np.linalg.solve(columns.T @ columns + np.diag(self.sensor_precision), columns.T @ residual)
        return s, 0.5 * float(np.sum((residual - columns @ s) ** 2) + self.sensor_precision @ s**2)


def fit(weighed: Weighed, free: Sequence[Free], x0: np.ndarray, *, steps: int = 25, tolerance: float = 3e-4) -> Fit:
    """Least squares over free parameters and sensors from a start strictly inside the bounds.

    Args:
        x0: (P,) in scales. steps: at most. tolerance: relative decrease of cost at which it ends.
    """
    model, until = weighed.model, weighed.until
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    x = np.clip(x0, low, high)
    delta = DELTA * np.array([min(f.sd, 1.0) if np.isfinite(f.sd) else 1.0 for f in free])
    delta = np.where(x + delta > high, -delta, delta)
    run = model.runs(free, x, until)[0]
    while not np.isfinite(run).all():  # a start too bold: half way back to where everything is off or usual
        x = center + 0.5 * (x - center)
        run = model.runs(free, x, until)[0]
    s, cost = weighed.solve_sensors(run)
    cost += _prior(x, center, sd)
    converged = False
    for _ in range(steps):
        probes = model.runs(free, x + np.diag(delta), until) if len(free) else np.empty((0, *run.shape))
        sensors = weighed.sensors(s)
        base = weighed.vector(sensors.read(run, model.reading_step, model.starts))
        read = [weighed.vector(sensors.read(p, model.reading_step, model.starts)) for p in probes]
        columns = [(y - base) / d for y, d in zip(read, delta, strict=True)]
        jacobian = np.column_stack([*columns, weighed.sensor_columns(run)])
        residual = weighed.vector(model.target) - base
        n = len(free)
        precision = np.concatenate([sd**-2.0, weighed.sensor_precision])
        gradient = jacobian.T @ residual - precision * np.concatenate([x - center, s])
        hessian = jacobian.T @ jacobian + np.diag(precision + 1e-9 * len(residual))
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
            solutions[k], left = weighed.solve_sensors(runs[k])
            costs[k] = left + _prior(trials[k], center, sd)
        best = int(np.argmin(costs))
        if not costs[best] < cost:
            converged = True
            break
        gained = cost - costs[best]
        x, run, s, cost = trials[best], runs[best], solutions[best], float(costs[best])
        delta = np.where((x + np.abs(delta) > high), -np.abs(delta), np.abs(delta))
        if gained < tolerance * cost or gained < 0.05:
            converged = True
            break
    sensors, run = weighed.sensors(s), model.runs(free, x)[0]
    return Fit(tuple(free), x, sensors, run, sensors.read(run, model.reading_step, model.starts), cost, converged)


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
