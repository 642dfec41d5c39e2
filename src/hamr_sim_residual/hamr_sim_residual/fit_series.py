"""Fits a series law to measured angles: by least squares on torques first, then by Gauss-Newton through whole roll-outs.

The law is linear in its weights. Inverse dynamics turns smoothed angles into torques, and one linear solution gives the warm
start. Encoder noise hurts that much, as it differentiates twice; so the fit proper compares angles with angles: it rolls the
simulator's own step out over windows and takes the weights and initial states that are most likely under white angle noise and
a weak prior. Initial states are eliminated window by window. Two or three iterations converge; nothing is random.

The prior says what any leg says of itself: the nonlinear part of each term is a share of the linear one, less so for each
degree. It decides nothing that the data decide, and keeps calm what a short run does not reach.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_dynamics.leg import inertia
from hamr_dynamics.leg_step import LANES

from .dataset import Stretch, Windows
from .inverse import ZERO3, torques
from .rollout import FREE, STRIDE, Rollout
from .series import LIMITS, RATE, TERMS, Series
from .simple import rigid_leg, simple_parameters

SHARE, DECAY = 0.3, 0.7  # prior: nonlinear part of a term relative to the linear one, and from one degree to the next
RATE_LIMIT = 0.75  # rad/ms: half as much again as full-voltage steps between +-23 degrees reach
ROWS = 40_000  # samples for the warm start, evenly spread; its error is the differentiation's, not the number's
CHUNK = 32  # blocks at a time: bounds the memory of the slopes
ENOUGH = 0.2  # posterior standard deviations (root mean square): a smaller step ends the fit; the next would be far smaller still
MAX_STEPS = 8


@dataclass(frozen=True, slots=True)
class Prior:
    """Gaussian prior of the weights after the limits: mean and standard deviation, (2 * TERMS * monomials,)."""

    mean: np.ndarray
    deviation: np.ndarray


def prior(law: Series) -> Prior:
    """The linear drive of HAMR-simple, give or take SHARE * DECAY^degree of its torques at full voltage, damping and inertia."""
    p = simple_parameters(LEGS[0])
    degree = np.array([sum(powers) for powers in law.powers])
    mass = max(inertia(rigid_leg((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), p).bodies, (0.0, 0.0), ZERO3, ZERO3).leg)
    mean, deviation = np.zeros((2, TERMS, len(degree))), np.zeros((2, TERMS, len(degree)))
    for i in (0, 1):
        drive = p["torque_per_volt"][i] * value("actuator.neutral_voltage")
        scale = np.array([drive] * 3 + [p["damping"][i] * RATE] * 2 + [mass * RATE**2] * 3)
        mean[i, 1 + i, 0] = drive
        deviation[i] = SHARE * scale[:, None] * DECAY**degree
    return Prior(mean.ravel(), deviation.ravel())


def limits() -> np.ndarray:
    """Limits of a law, in the order of LIMITS: HAMR-simple's stops and the rate limit."""
    p = simple_parameters(LEGS[0])
    return np.array([*p["stop_low"], *p["stop_high"], RATE_LIMIT])


def warm_start(law: Series, parts: Sequence[Stretch]) -> np.ndarray:
    """Weights (W,) by linear least squares on the torques of inverse dynamics."""
    rows = [_torque_rows(part, i, leg) for part in parts for i, leg in enumerate(LEGS)]
    q, v, a, drive, torque = (np.concatenate(column) for column in zip(*rows, strict=True))
    every = -(-len(q) // ROWS)
    spread = max(1.0, (2 * parts[0].half_width + 1) / every)  # rows that share one smoothing window count as one
    bound = limits()
    design = law.design(q[::every], v[::every], a[::every], drive[::every], bound)
    gram, known = design.T @ design, prior(law)
    weights = []
    for i, (mean, deviation) in enumerate(zip(known.mean.reshape(2, -1), known.deviation.reshape(2, -1), strict=True)):
        rest = torque[::every, i] - design @ mean
        variance = float(np.var(rest))
        for _ in range(4):  # the noise of the torques is unknown: fitted along
            noise = spread * max(variance, 1e-16)
            step = np.linalg.solve(gram / noise + np.diag(deviation**-2), design.T @ rest / noise)
            variance = float(np.var(rest - design @ step))
        weights.append(mean + step)
    return np.concatenate([bound, *weights])


def _torque_rows(part: Stretch, i: int, leg: str):
    torque, before = torques(part.q[i], part.v[i], simple_parameters(leg))
    clear = np.flatnonzero(part.inside[i, 1:-1]) + 1
    return part.q[i, clear], part.v[i, clear], before[clear], part.drive[i, clear], torque[clear]


@dataclass(slots=True)
class Fit:
    """Where a fit stands; `arrays` is all it needs to go on to the bit.

    Attributes:
        weights: (W,). state0: initial states of the windows, as `Windows.state0`.
        deviation: of an angle sample from the roll-outs, rad. step: the last one, in posterior standard deviations. steps: taken.
    """

    weights: np.ndarray
    state0: np.ndarray
    deviation: float = float("nan")
    step: float = float("inf")
    steps: int = 0

    @property
    def done(self) -> bool:
        """Whether another step would change nothing that the data can tell."""
        return self.step < ENOUGH or self.steps >= MAX_STEPS

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """For a checkpoint."""
        return {"weights": self.weights, "state0": self.state0, "figures": np.array([self.deviation, self.step, self.steps])}

    @classmethod
    def of(cls, arrays) -> Fit:
        """From a checkpoint."""
        deviation, step, steps = arrays["figures"]
        return cls(arrays["weights"], arrays["state0"], float(deviation), float(step), int(steps))


def improve(fit: Fit, law: Series, windows: Windows) -> Iterator[float]:
    """One Gauss-Newton step, in place; yields the share done after each chunk, the last time when the step is taken."""
    roll, known, first = Rollout(law), prior(law), len(LIMITS)
    count = len(fit.weights) - first
    gram, pull, squares, freedom = np.zeros((count, count)), np.zeros(count), 0.0, 0
    state0, kept = fit.state0.copy(), []
    for start in range(0, len(windows), CHUNK):
        blocks = slice(start, start + CHUNK)
        part = windows[blocks]
        error, slope = roll(part, state0[blocks], fit.weights, slopes="state")
        _shift(state0[blocks], _least_squares(slope, error.reshape(len(error), -1)))
        error, slope = roll(part, state0[blocks], fit.weights, slopes="all")
        error, of_state, of_weight = error.reshape(len(error), -1), slope[:, :, :FREE], slope[:, :, FREE + first :]
        back = of_state.transpose(0, 2, 1)
        cross = back @ of_weight
        by_weight = np.linalg.solve(back @ of_state, cross)  # initial state that goes with a change of weights
        rest = np.linalg.solve(back @ of_state, back @ error[..., None])[..., 0]
        flat = of_weight.reshape(-1, count)
        gram += flat.T @ flat - cross.reshape(-1, count).T @ by_weight.reshape(-1, count)
        pull += flat.T @ error.ravel() - cross.reshape(-1, count).T @ rest.ravel()
        squares += float(np.sum(error**2))
        freedom += error.size - rest.size
        kept.append((blocks, rest, by_weight))
        yield min(start + CHUNK, len(windows)) / (len(windows) + 1)
    variance = squares / freedom
    precision = gram / variance + np.diag(known.deviation**-2)
    change = np.linalg.solve(precision, pull / variance + (known.mean - fit.weights[first:]) / known.deviation**2)
    for blocks, rest, by_weight in kept:
        _shift(state0[blocks], rest - by_weight @ change)
    fit.weights = np.concatenate([fit.weights[:first], fit.weights[first:] + change])
    fit.state0, fit.deviation, fit.step = state0, (STRIDE * variance) ** 0.5, float(np.sqrt(change @ precision @ change / count))
    fit.steps += 1
    yield 1.0


def _least_squares(slope: np.ndarray, error: np.ndarray) -> np.ndarray:
    back = slope.transpose(0, 2, 1)
    return np.linalg.solve(back @ slope, back @ error[..., None])[..., 0]


def _shift(state0: np.ndarray, change: np.ndarray) -> None:
    """Adds (windows, FREE) to initial states (blocks, 6 * 16), in place."""
    state0.reshape(-1, 6, LANES)[:, :FREE] += change.reshape(-1, LANES, FREE).transpose(0, 2, 1)
