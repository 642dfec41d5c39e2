"""Segments replayed, and starts that the model itself agrees with: each segment's own least squares about what smoothing says.

A foot that starts a twentieth of a millimetre too deep is thrown up, which no linear step mends; so the horizon grows, and the first
few milliseconds put the feet where they can be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .observe import Observed, observed
from .robot import Robot
from .segments import CHANGES, Segments, apart, moved
from .setting import ZEROS, Setting

PROBE = 0.003  # of a start's standard deviation: little beside the depth to which feet sink
GROWING = ((4.0, 4), (8.0, 3), (12.0, 3), (16.0, 2), (24.0, 2), (32.0, 2))  # ms of a segment, and rounds of steps on them
DAMPINGS = (0.0, 0.03, 0.3, 3.0)  # shares of its curvature added to each direction
ROUNDS = 6  # on whole segments
#: What a zero of the sensors does to what smoothing says of a start.
ZERO_OF_START = np.zeros((len(ZEROS), CHANGES))
ZERO_OF_START[np.arange(len(ZEROS)), [2, 3, 4, *range(12, 20)]] = 1.0
USUAL = 1.1  # times the median of half squares, above which another start may do better
SETTLED = 0.5  # gain in half squares below which a segment is done


@dataclass(frozen=True)
class Replay:
    """Segments and a robot to replay them.

    Attributes:
        robot, segments, observed.
    """

    robot: Robot
    segments: Segments
    observed: Observed

    @classmethod
    def of(cls, robot: Robot, segments: Segments) -> Replay:
        """With the readings of segments."""
        return cls(robot, segments, observed(segments, robot.steps))

    def __len__(self) -> int:
        return len(self.segments)

    def some(self, index: np.ndarray) -> Replay:
        """Of a choice of segments."""
        return Replay(self.robot, self.segments.some(index), self.observed.some(index))

    def residual(self, change: np.ndarray, settings: Sequence[Setting], which: np.ndarray, segment: np.ndarray) -> np.ndarray:
        """(n, readings + 28) in units of noise, of lanes: starts of segment[i] changed by (n, 28) standard deviations, under
        settings[which[i]]; the last 28 are the smoothed start against this one."""
        zeros, gains = (np.array([getattr(s, name) for s in settings])[which] for name in ("zeros", "gains"))
        starts = moved(self.segments.starts[segment], change * self.segments.sd)
        runs = self.robot.run(starts, self.observed.drives, settings, which, segment)
        own = self.smoothed(zeros, gains, segment) - change
        return np.concatenate([self.observed.residual(starts, runs, zeros, gains, segment), own], 1)

    def smoothed(self, zeros: np.ndarray, gains: np.ndarray, segment: np.ndarray) -> np.ndarray:
        """(n, 28) changes to what smoothing says of the starts of segment[i] if sensors are off by zeros[i] (11,) and gains[i] (8,)."""
        sd = self.segments.sd
        change = -zeros @ (ZERO_OF_START / sd)
        change[:, 12:] -= np.tile(gains, 2) * self.segments.starts[segment, 13:] / sd[12:]
        return change

    def each(self, change: np.ndarray, settings: Sequence[Setting]) -> np.ndarray:
        """(m, s, readings + 28) of all segments under each of m settings."""
        s, m = len(self), len(settings)
        segment = np.tile(np.arange(s), m)
        return self.residual(np.tile(change, (m, 1)), settings, np.repeat(np.arange(m), s), segment).reshape(m, s, -1)

    @property
    def zeros(self) -> np.ndarray:
        """(s, readings + 28, 11) derivatives of what is predicted by the sensors' zeros."""
        seen = self.observed.zeros
        own = np.broadcast_to((ZERO_OF_START / self.segments.sd).T, (len(self), CHANGES, len(ZEROS)))
        return np.concatenate([seen, own], 1)

    def slopes(self, change: np.ndarray, residual: np.ndarray, model: Setting) -> np.ndarray:
        """(s, readings + 28, 28) derivatives of what is predicted by changes of the start."""
        s = len(self)
        lanes = (change[:, None] + PROBE * np.eye(CHANGES)).reshape(-1, CHANGES)
        probed = self.residual(lanes, [model], np.zeros(len(lanes), int), np.repeat(np.arange(s), CHANGES))
        return ((residual[:, None] - probed.reshape(s, CHANGES, -1)) / PROBE).transpose(0, 2, 1)


@dataclass(frozen=True)
class Started:
    """Starts of segments under one model.

    Attributes:
        change: (s, 28) from the smoothed ones, in standard deviations. residual: (s, readings + 28). cost: (s,) half squares.
    """

    change: np.ndarray
    residual: np.ndarray
    cost: np.ndarray


def start(replay: Replay, model: Setting, change: np.ndarray | None = None) -> Started:
    """Fits the starts of all segments: from earlier changes (s, 28), or anew."""
    if change is not None:
        return _stepped(replay, model, change, ROUNDS)
    return _improved(replay, model, _grown(replay, model, _smoothed(replay, model)), _led)


def best_start(replay: Replay, model: Setting, change: np.ndarray) -> Started:
    """The same from earlier changes (s, 28), and anew where these leave more than usual; contact has many minima."""
    return _improved(replay, model, start(replay, model, change), _smoothed, _led)


def _improved(replay: Replay, model: Setting, found: Started, *ways: Callable[[Replay, Setting], np.ndarray]) -> Started:
    """Starts with those that cost more than usual fitted from elsewhere too, and the better kept."""
    change, residual, cost = found.change.copy(), found.residual.copy(), found.cost.copy()
    for way in ways:
        if not len(doubtful := np.flatnonzero(cost > USUAL * np.median(cost))):
            break
        part = replay.some(doubtful)
        other = _grown(part, model, way(part, model))
        better = other.cost < cost[doubtful]
        for mine, its in ((change, other.change), (residual, other.residual), (cost, other.cost)):
            mine[doubtful[better]] = its[better]
    return Started(change, residual, cost)


def _smoothed(replay: Replay, model: Setting) -> np.ndarray:
    """(s, 28) changes to the smoothed starts, without what a model has for errors of the sensors."""
    s = len(replay)
    return replay.smoothed(*(np.tile(errors, (s, 1)) for errors in (model.zeros, model.gains)), np.arange(s))


def _led(replay: Replay, model: Setting) -> np.ndarray:
    """(s, 28) changes to where a model ends that runs from a start of its own through the stretch before each segment.

    Where feet stand decides what a segment does, and what they did before says more of that than smoothing does.
    """
    segments, before = replay.segments, Replay.of(replay.robot, replay.segments.before)
    begun = _grown(before, model, _smoothed(before, model)).change
    lanes = np.arange(len(replay))
    begun = moved(before.segments.starts, begun * before.segments.sd)
    ends = replay.robot.run(begun, before.observed.drives, [model], np.zeros_like(lanes), lanes).ends
    change = apart(segments.starts, ends) / segments.sd
    return np.where(np.isfinite(change).all(1, keepdims=True), change, _smoothed(replay, model))


def _grown(replay: Replay, model: Setting, change: np.ndarray) -> Started:
    """Starts fitted with a growing horizon."""
    for ms, rounds in GROWING:
        samples = round(ms / replay.segments.walk.step)
        if samples < replay.segments.samples:
            short = Replay.of(replay.robot, replace(replay.segments, samples=samples))
            change = _stepped(short, model, change, rounds).change
    return _stepped(replay, model, change, ROUNDS)


def _stepped(replay: Replay, model: Setting, change: np.ndarray, rounds: int) -> Started:
    """Damped Gauss-Newton steps of every segment's start; those that have settled rest."""
    change, residual = change.copy(), replay.each(change, [model])[0]
    cost = half_squares(residual)
    active = np.arange(len(replay))
    for _ in range(rounds):
        part = replay.some(active)
        slopes = part.slopes(change[active], residual[active], model)
        hessian = np.einsum("sci,scj->sij", slopes, slopes, optimize=True)
        gradient = np.einsum("sci,sc->si", slopes, residual[active])
        diagonal = np.einsum("sii->si", hessian)[:, :, None] * np.eye(CHANGES)
        tries = np.concatenate([change[active] + np.linalg.solve(hessian + d * diagonal, gradient[..., None])[..., 0] for d in DAMPINGS])
        segment = np.tile(np.arange(len(active)), len(DAMPINGS))
        left = part.residual(tries, [model], np.zeros(len(tries), int), segment)
        costs = half_squares(left).reshape(len(DAMPINGS), -1)
        best = np.argmin(costs, 0)
        pick = best * len(active) + np.arange(len(active))
        gain = cost[active] - costs[best, np.arange(len(active))]
        better = gain > 0
        where, pick = active[better], pick[better]
        change[where], residual[where], cost[where] = tries[pick], left[pick], cost[where] - gain[better]
        active = active[gain > np.maximum(SETTLED, 0.01 * cost[active])]
        if not len(active):
            break
    return Started(change, residual, cost)


def half_squares(residual: np.ndarray) -> np.ndarray:
    """(n,) of (n, c); infinite where a run diverged."""
    cost = 0.5 * np.sum(residual**2, 1)
    return np.where(np.isfinite(cost), cost, np.inf)
