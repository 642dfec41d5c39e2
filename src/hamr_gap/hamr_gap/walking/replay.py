"""Segments replayed: from starts and models to what is left of the readings, in units of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .observe import Observed, observed
from .robot import Robot
from .segments import CHANGES, Segments, moved
from .setting import ZEROS, Setting

PROBE = 0.003  # of a start's standard deviation: little beside the depth to which feet sink
#: What a zero of the sensors does to what smoothing says of a start.
ZERO_OF_START = np.zeros((len(ZEROS), CHANGES))
ZERO_OF_START[np.arange(len(ZEROS)), [2, 3, 4, *range(12, 20)]] = 1.0


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
        return (chord(residual[:, None], probed.reshape(s, CHANGES, -1)) / PROBE).transpose(0, 2, 1)

    def suited(self, models: Sequence[Setting], ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (m, s, readings + 28) and changes (m, s, 28) under models, of ways (m, d, s, 28) that which suits each segment."""
        m, d, s = ways.shape[:3]
        left = self.residual(ways.reshape(m * d * s, -1), models, np.repeat(np.arange(m), d * s), np.tile(np.arange(s), m * d))
        suits = np.argmin(half_squares(left).reshape(m, d, s), 1)
        pick = np.arange(m)[:, None], suits, np.arange(s)
        return left.reshape(m, d, s, -1)[pick], ways[pick]

    def ends(self, change: np.ndarray, model: Setting) -> np.ndarray:
        """(s, 29) states at the ends of segments with starts changed by (s, 28)."""
        lanes = np.arange(len(self))
        starts = moved(self.segments.starts, change * self.segments.sd)
        return self.robot.run(starts, self.observed.drives, [model], np.zeros_like(lanes), lanes).ends


def chord(residual: np.ndarray, probed: np.ndarray) -> np.ndarray:
    """What another run (..., c) takes off residuals (..., c); nothing where one of the two diverged, for it does not say where to go."""
    ran = np.isfinite(residual).all(-1, keepdims=True) & np.isfinite(probed).all(-1, keepdims=True)
    return np.subtract(residual, probed, out=np.zeros(np.broadcast_shapes(residual.shape, probed.shape)), where=ran)


def half_squares(residual: np.ndarray) -> np.ndarray:
    """(n,) of (n, c); infinite where a run diverged."""
    with np.errstate(over="ignore"):  # as a run does that diverges and has not got to infinity yet
        cost = 0.5 * np.sum(residual**2, 1)
    return np.where(np.isfinite(cost), cost, np.inf)
