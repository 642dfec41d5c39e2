"""What other starts explain of a walk's pieces: nobody knows the states that they begin in better than sensors tell.

A foot that sinks a few hundredths of a millimetre deeper is, to the sensors, a chassis that stood as much higher.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from hamr_description.names import JOINTS
from hamr_description.rates import SERVO_HZ
from hamr_description.units import length_from_si, time_from_si

from .machine import EVERY, Walker
from .strength import FRAME, Floors, Pieces

#: Numbers of a start: position, orientation, hip angles, and the rates of these.
STARTS = 2 * (6 + len(JOINTS))
#: Rounds in which starts are fitted on by themselves, and shares of a step that are tried: contacts bend all curves.
ROUNDS, SHARES = 2, (1.0, 0.5, 0.2)
#: ms over which a rate is known to a floor: between two poses of motion capture; of the hips, over a few samples of an encoder.
POSE_MS, HIP_MS = time_from_si(FRAME * EVERY / SERVO_HZ), 1.0


def scale(floors: Floors) -> np.ndarray:
    """(STARTS,) what a start is uncertain by: mm, rad, and these per ms."""
    pose = np.repeat([length_from_si(floors.position), floors.orientation], 3)
    hips = np.full(len(JOINTS), floors.angle)
    return np.concatenate([pose, hips, pose / POSE_MS, hips / HIP_MS])


def moved(pieces: Pieces, away: np.ndarray) -> Pieces:
    """The pieces begun elsewhere, by (s, STARTS) in units of `scale`."""
    change, qpos = away * scale(pieces.floors), pieces.qpos.copy()
    qpos[:, :3] += change[:, :3]
    qpos[:, 7:] += change[:, 6 : STARTS // 2]
    for quaternion, turn in zip(qpos[:, 3:7], change[:, 3:6], strict=True):
        mujoco.mju_quatIntegrate(quaternion, turn, 1.0)
    return replace(pieces, qpos=qpos, qvel=pieces.qvel + change[:, STARTS // 2 :])


@dataclass(frozen=True, slots=True)
class Starts:
    """Least squares over the start of every piece.

    Attributes:
        basis, slopes: (s, readings + STARTS, STARTS) what starts do to readings and to their own uncertainty: orthonormal, and as they are.
    """

    basis: np.ndarray
    slopes: np.ndarray

    @classmethod
    def of(cls, pieces: Pieces, robot: Walker, here: np.ndarray) -> Starts:
        """About a robot that misses the pieces by (s, readings)."""
        columns = [here - moved(pieces, np.tile(one, (len(here), 1))).missed(robot) for one in np.eye(STARTS)]
        slopes = np.concatenate([np.stack(columns, axis=2), np.tile(np.eye(STARTS), (len(here), 1, 1))], axis=1)
        return cls(np.linalg.qr(slopes).Q, slopes)

    def beyond(self, x: np.ndarray) -> np.ndarray:
        """(s, readings + STARTS, ...) less what starts explain of it."""
        flat = x.reshape(*x.shape[:2], -1)
        return (flat - self.basis @ (self.basis.transpose(0, 2, 1) @ flat)).reshape(x.shape)

    def best(self, x: np.ndarray) -> np.ndarray:
        """(s, STARTS) that explain most of (s, readings + STARTS)."""
        return np.stack([np.linalg.lstsq(slopes, own, rcond=None)[0] for slopes, own in zip(self.slopes, x, strict=True)])


def beside(x: np.ndarray, away: np.ndarray) -> np.ndarray:
    """(s, readings + STARTS, ...): of readings (s, readings, ...), with what starts (s, STARTS, ...) miss of what they are known to be."""
    return np.concatenate([x, -away], axis=1)


def settled(given: Pieces, robot: Walker, explained: np.ndarray, away: np.ndarray) -> np.ndarray:
    """(s, STARTS) from which a robot misses pieces least, beginning with `away`; besides, sensors explain (s, readings)."""

    def rest(away: np.ndarray) -> np.ndarray:
        return beside(moved(given, away).missed(robot) - explained, away)

    now = rest(away)
    for _ in range(ROUNDS):
        step = Starts.of(moved(given, away), robot, now[:, :-STARTS] + explained).best(now)
        for tried in (away + share * step for share in SHARES):
            other = rest(tried)
            better = np.sum(other**2, axis=1) < np.sum(now**2, axis=1)
            away, now = np.where(better[:, None], tried, away), np.where(better[:, None], other, now)
    return away
