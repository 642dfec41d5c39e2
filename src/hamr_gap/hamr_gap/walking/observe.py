"""What segments should have shown, in units of the sensors' noise: means of angles after the start, and every pose from the start on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.signal import savgol_filter

from hamr_description.rates import SERVO_MS

from .robot import Drives, Runs
from .segments import NEAR_MS, POSITION, QUATERNION, Segments
from .walk import Noise, Walk, turn_between

MEAN_MS = 1.0  # of the angles that count as one reading
LEAD_MS = 12.0  # before a segment, over which effects take up what they remember


@dataclass(frozen=True)
class Observed:
    """Readings of segments, and the drives under them.

    Attributes:
        drives. angles: (s, g, 8) means of `mean` samples each, rad.
        at: (s, p) samples after the start of each pose, 0 for the start's own. position: (s, p, 3). quaternion: (s, p, 4).
        there: (s, p) whether a pose exists. noise: of these readings. mean: samples in a reading of angles.
    """

    drives: Drives
    angles: np.ndarray
    at: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    there: np.ndarray
    noise: Noise
    mean: int

    @property
    def readings(self) -> int:
        """How many there are of a segment, at most."""
        return 8 * self.angles.shape[1] + 6 * self.at.shape[1]

    def some(self, index: np.ndarray) -> Observed:
        """Of a choice of segments."""
        own = {name: getattr(self, name)[index] for name in ("angles", "at", "position", "quaternion", "there")}
        return replace(self, drives=self.drives.some(index), **own)

    def residual(self, starts: np.ndarray, runs: Runs, zeros: np.ndarray, gains: np.ndarray, segment: np.ndarray) -> np.ndarray:
        """(n, readings) measurement minus run, lane i being one of segment[i] with sensors whose zeros are off by zeros[i] (11,) and that
        read too much by gains[i] (8,)."""
        n, lanes = len(segment), np.arange(len(segment))[:, None]
        seen = runs.angles.reshape(n, -1, self.mean, 8).mean(2) * (1.0 + gains[:, None]) + zeros[:, None, 3:]
        angles = (self.angles[segment] - seen) / self.noise.angle
        at = self.at[segment]
        position = np.where(at[..., None] > 0, runs.position[lanes, at - 1], starts[:, None, POSITION])
        quaternion = np.where(at[..., None] > 0, runs.quaternion[lanes, at - 1], starts[:, None, QUATERNION])
        up, lean = zeros[:, None, :1] * np.array([0.0, 0.0, 1.0]), np.pad(zeros[:, 1:3], ((0, 0), (0, 1)))[:, None]
        away = (self.position[segment] - position - up) / self.noise.position
        turn = (turn_between(quaternion, self.quaternion[segment]) - lean) / self.noise.turn
        poses = np.concatenate([away, turn], -1) * self.there[segment][..., None]
        return np.concatenate([angles.reshape(n, -1), poses.reshape(n, -1)], 1)

    @property
    def zeros(self) -> np.ndarray:
        """(s, readings, 11) derivatives of what is predicted by the sensors' zeros (height, roll, pitch, angles)."""
        s, g = self.angles.shape[:2]
        angles = np.zeros((s, g, 8, 11))
        angles[..., 3:] = np.diag(1.0 / self.noise.angle)
        poses = np.zeros((s, self.at.shape[1], 6, 11))
        poses[:, :, 2, 0], poses[:, :, 3, 1], poses[:, :, 4, 2] = 1.0 / self.noise.position[2], *(1.0 / self.noise.turn[:2])
        poses *= self.there[..., None, None]
        return np.concatenate([angles.reshape(s, -1, 11), poses.reshape(s, -1, 11)], 1)

    def apart(self, each: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What readings (s, readings) have, of angles (s, g, 8) and of poses (s, p, 6), position and turn."""
        s = len(each)
        return each[:, : self.angle_readings].reshape(s, -1, 8), each[:, self.angle_readings :].reshape(s, -1, 6)

    def parts(self, each: np.ndarray, some: np.ndarray | slice = slice(None)) -> np.ndarray:
        """(7,) means of the same over some segments: of all angles, and of each axis of the chassis."""
        angles, poses = self.apart(each[some])
        return np.array([angles.mean(), *poses[self.there[some]].mean(0)])

    @property
    def angle_readings(self) -> int:
        """How many of the readings are angles; they come first."""
        return 8 * self.angles.shape[1]


def observed(segments: Segments, fine: int) -> Observed:
    """Readings of segments, for a simulation with `fine` steps to a servo period."""
    walk, first = segments.walk, segments.first
    steps = round(walk.step / SERVO_MS) * fine
    mean = max(1, round(MEAN_MS / walk.step))
    while segments.samples % mean:
        mean -= 1
    noise = Noise(walk.noise.angle / np.sqrt(mean), walk.noise.position, walk.noise.turn)
    after = first[:, None] + 1 + np.arange(segments.samples)
    begin = np.searchsorted(walk.seen, first)
    most = int(np.max(np.searchsorted(walk.seen, first + segments.samples, side="right") - begin))
    index = np.minimum(begin[:, None] + np.arange(most), len(walk.seen) - 1)
    at = walk.seen[index] - first[:, None]
    there = (at >= 0) & (at <= segments.samples)
    angles = walk.angles[after].reshape(len(first), -1, mean, 8).mean(2)
    return Observed(
        _drives(segments, steps), angles, np.where(there, at, 0), walk.position[index], walk.quaternion[index], there, noise, mean
    )


def _drives(segments: Segments, steps: int) -> Drives:
    walk, first = segments.walk, segments.first
    volts, slopes, bends, angles, rates = _even(walk, steps)
    during = first[:, None] + np.arange(segments.samples)
    before = np.maximum(first[:, None] - np.arange(round(LEAD_MS / walk.step), 0, -1), 0)
    return Drives(volts[during], slopes[during], bends[during], volts[before], slopes[before], angles[before], rates[before])


@lru_cache(maxsize=2)
def _even(walk: Walk, steps: int) -> tuple[np.ndarray, ...]:
    """Of a whole walk: voltages with two derivatives (n, steps, 8), smoothed angles and rates (n, 8)."""
    fine = walk.record.fine(steps)
    slopes = np.gradient(fine, walk.step / steps, axis=0)
    bends = np.gradient(slopes, walk.step / steps, axis=0)
    window = 2 * round(NEAR_MS / walk.step) + 1
    angles = savgol_filter(walk.angles, window, 3, axis=0)
    rates = savgol_filter(walk.angles, window, 3, deriv=1, delta=walk.step, axis=0)
    return *(x.reshape(-1, steps, 8) for x in (fine, slopes, bends)), angles, rates
