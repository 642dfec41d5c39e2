"""Starts that the model itself agrees with: each segment's own least squares about what smoothing says.

A foot that starts a twentieth of a millimetre too deep is thrown up, which no linear step mends; so the horizon grows, and the first
few milliseconds put the feet where they can be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .eliminate import Eliminated
from .replay import Replay, half_squares
from .segments import apart
from .setting import Setting

GROWING = ((4.0, 4), (8.0, 3), (12.0, 3), (16.0, 2), (24.0, 2), (32.0, 2))  # ms of a segment, and rounds of steps on them
DAMPINGS = (0.0, 0.03, 0.3, 3.0)  # shares of its curvature added to each direction
ROUNDS = 6  # on whole segments
USUAL = 1.1  # times the median of half squares, above which another start may do better
SETTLED = 0.5  # gain in half squares below which a segment is done


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
    ends = before.ends(_grown(before, model, _smoothed(before, model)).change, model)
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
        linear = Eliminated(part.slopes(change[active], residual[active], model))
        ways = change[active] + linear.starts(residual[active], DAMPINGS)
        (left,), (tried,) = part.suited([model], ways[None])
        costs = half_squares(left)
        better = costs < cost[active]
        gain = np.subtract(cost[active], costs, out=np.zeros_like(costs), where=better)
        where = active[better]
        change[where], residual[where], cost[where] = tried[better], left[better], costs[better]
        active = active[gain > np.maximum(SETTLED, 0.01 * cost[active])]
        if not len(active):
            break
    return Started(change, residual, cost)
