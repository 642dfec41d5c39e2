"""What was measured of a walking robot: drive voltages, hip angles and the pose of the chassis, in inside units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hamr_description.errors import BagError
from hamr_description.names import JOINTS

from ..data.readings import noise_of
from ..data.record import Record

#: The least that readings may scatter: angles as a share of their range (the finest encoder in use), poses in mm and rad. Those of a
#: simulation are exact, but contact is stiff, and no fit finds starts closer.
FINEST_ANGLE, FINEST_POSITION, FINEST_TURN = 2e-4, 0.02, 1e-3


@dataclass(frozen=True, eq=False)  # known by identity, so that what is made of a whole walk can be kept
class Walk:
    """Even servo samples of one run and the poses seen meanwhile.

    Attributes:
        voltages: (n * k, 8) V, k for each sample. angles: (n, 8) rad. step: ms between samples.
        seen: (m,) samples at which the chassis was seen, rising. position: (m, 3) mm in the world.
        quaternion: (m, 4) wxyz. breaks: samples at which a new stretch begins, recorded at another time.
        known: the noise where it is not to be taken from the readings.
    """

    voltages: np.ndarray
    angles: np.ndarray
    step: float
    seen: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    breaks: tuple[int, ...] = ()
    known: Noise | None = None

    def __post_init__(self) -> None:
        if not np.isfinite(self.angles).all():
            raise BagError("Hip angles were lost in between: cut the bag there, or record it again.")
        if len(self.seen) < 2 or (np.diff(self.seen) < 1).any():
            raise BagError("The chassis was hardly ever seen: record its pose, at least twice in every 20 ms.")

    @cached_property
    def record(self) -> Record:
        """Drives and angles as the rest of the workflow has them."""
        per = len(self.voltages) // len(self.angles)
        return Record(self.voltages, self.angles, self.step, JOINTS, rest=False, drives_per_reading=per, breaks=self.breaks)

    @property
    def turns(self) -> np.ndarray:
        """(m - 1, 3) rad from each pose to the next, in the axes of the first."""
        return turn_between(self.quaternion[:-1], self.quaternion[1:])

    @cached_property
    def noise(self) -> Noise:
        """Of the sensors, from differences of high order; no less than the finest."""
        if self.known:
            return self.known
        path = np.cumsum(np.vstack([np.zeros(3), self.turns]), axis=0)  # smooth but for the noise of each pose
        angle, position, turn = (noise_of(x, chance=0.0) for x in (self.angles, self.position, path))  # feet hit the ground
        least = FINEST_ANGLE * np.ptp(self.angles, axis=0)
        return Noise(np.maximum(angle, least), np.maximum(position, FINEST_POSITION), np.maximum(turn, FINEST_TURN))


def joined(walks: Sequence[Walk]) -> Walk:
    """Several walks of one robot as one, in stretches.

    Raises:
        BagError: they differ in their sample times.
    """
    first = walks[0]
    if not all(
        np.isclose(w.step, first.step, rtol=1e-4) and len(w.voltages) * len(first.angles) == len(first.voltages) * len(w.angles)
        for w in walks
    ):
        raise BagError("Bags of one robot must have the same sample rates: resample them or leave one out.")
    begins = np.cumsum([0, *(len(w.angles) for w in walks)])
    breaks = tuple(int(b + begin) for w, begin in zip(walks, begins, strict=False) for b in (0, *w.breaks) if b + begin)
    whole = {name: np.concatenate([getattr(w, name) for w in walks]) for name in ("voltages", "angles", "position", "quaternion")}
    seen = np.concatenate([w.seen + begin for w, begin in zip(walks, begins, strict=False)])
    return Walk(**whole, step=first.step, seen=seen, breaks=breaks)


@dataclass(frozen=True)
class Noise:
    """Standard deviations of single readings: angle (8,) rad, position (3,) mm, turn (3,) rad."""

    angle: np.ndarray
    position: np.ndarray
    turn: np.ndarray


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., 4) product of quaternions wxyz."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    p, q, r, s = np.moveaxis(b, -1, 0)
    return np.stack([w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r,
                     w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p], -1)  # fmt: skip


def turned(quaternion: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(..., 4) orientation after a turn (..., 3) rad about the body's axes."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    return product(quaternion, np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2 * np.pi)) * turn], -1))


def turn_between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(..., 3) rad, the turn about the body's axes from one orientation to another."""
    inverse = start * np.array([1.0, -1.0, -1.0, -1.0])
    difference = product(inverse, end)
    difference = difference * np.where(difference[..., :1] < 0, -1.0, 1.0)
    size = np.linalg.norm(difference[..., 1:], axis=-1, keepdims=True)
    return difference[..., 1:] * (2.0 * np.arctan2(size, difference[..., :1]) / np.maximum(size, 1e-300))
