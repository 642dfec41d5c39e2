"""Segments of a walk that start anew, and what smoothing says about the state at each start.

A state is a row of 29 numbers: position mm, quaternion wxyz, velocity mm/ms (world), spin rad/ms (body axes), hip angles rad and
rates rad/ms. A change of it is a row of 28, with a turn about the body's axes in the quaternion's place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .walk import Walk, turn_between, turned

POSITION, QUATERNION, VELOCITY, SPIN, Q, QD = (slice(*ends) for ends in ((0, 3), (3, 7), (7, 10), (10, 13), (13, 21), (21, 29)))
STATE, CHANGES = 29, 28
NEAR_MS = 1.5  # to either side, of the angles that a start is smoothed from
POSES = 2  # to either side, that it is smoothed from
BEFORE_MS = 20.0  # of the stretch that leads up to a segment
LOOSE = 1.5  # by how many of its standard deviations a smoothed start may be off at the cost of one: neighbours are seen twice


@dataclass(frozen=True)
class Segments:
    """Stretches of a walk, each with a start of its own.

    Attributes:
        walk. first: (s,) samples at which they start. samples: of each, the start's not counted.
        starts: (s, 29) smoothed states. sd: (28,) standard deviations of their changes, loosened.
        before: the stretches that end where these start; run from starts of their own they say where feet are. None of those themselves.
    """

    walk: Walk
    first: np.ndarray
    samples: int
    starts: np.ndarray
    sd: np.ndarray
    before: Segments | None

    def __len__(self) -> int:
        return len(self.first)

    def some(self, index: np.ndarray) -> Segments:
        """A choice of them."""
        before = self.before.some(index) if self.before else None
        return Segments(self.walk, self.first[index], self.samples, self.starts[index], self.sd, before)


def moved(states: np.ndarray, change: np.ndarray) -> np.ndarray:
    """(..., 29) states after changes (..., 28)."""
    change = np.broadcast_to(change, (*np.broadcast_shapes(states.shape[:-1], change.shape[:-1]), CHANGES))
    quaternion = turned(states[..., QUATERNION], change[..., 3:6])
    return np.concatenate([states[..., POSITION] + change[..., :3], quaternion, states[..., 7:] + change[..., 6:]], -1)


def segments(walk: Walk, *, length_ms: float, every_ms: float) -> Segments:
    """Segments of a length, one after the other at distances of at least `every_ms`, each from a sample at which the chassis is seen.

    Raises:
        BagError: the walk is too short.
    """
    samples, near, before = (round(ms / walk.step) for ms in (length_ms, NEAR_MS, BEFORE_MS))
    chosen: list[int] = []
    for first in walk.seen:
        if (not chosen or (first - chosen[-1]) * walk.step >= every_ms - 1e-9) and _whole(walk, first, near, before, samples):
            chosen.append(first)
    if len(chosen) < 8:
        raise BagError(f"The walk has {len(chosen)} segments of {length_ms:g} ms: too few to learn from; record longer.")
    first = np.array(chosen)
    starts, noise = _smoothed(walk, first, near, POSES)
    wide, _ = _smoothed(walk, first, near, POSES - 1)
    narrow, _ = _smoothed(walk, first, near // 2, POSES)
    moves = np.hypot(apart(wide, starts).std(0), apart(narrow, starts).std(0))  # how much the choice of neighbours matters
    sd, earlier = LOOSE * np.hypot(noise, moves), first - before
    lead = Segments(walk, earlier, before, _smoothed(walk, earlier, near, POSES)[0], sd, None)
    return Segments(walk, first, samples, starts, sd, lead)


def _nearest(walk: Walk, at: np.ndarray) -> np.ndarray:
    """Indices of the poses nearest to samples."""
    after = np.clip(np.searchsorted(walk.seen, at), 1, len(walk.seen) - 1)
    return after - (at - walk.seen[after - 1] < walk.seen[after] - at)


def _whole(walk: Walk, first: int, near: int, before: int, samples: int) -> bool:
    """Whether a segment from a sample, with what leads up to it and all that smoothing needs, was recorded without a break."""
    begin, end = (int(_nearest(walk, np.array(at))) for at in (first - before, first))
    if begin < POSES or end + POSES >= len(walk.seen):
        return False
    window = walk.seen[begin - POSES : end + POSES + 1]
    start, last = min(int(window[0]), first - before - near), max(int(window[-1]), first + max(near, samples))
    dense = np.diff(window).max() < 1.5 * np.median(np.diff(walk.seen))
    return dense and start >= 0 and last < len(walk.angles) and not any(start < b <= last for b in walk.breaks)


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, 28) changes from states to others."""
    return np.concatenate([b[:, :3] - a[:, :3], turn_between(a[:, QUATERNION], b[:, QUATERNION]), b[:, 7:] - a[:, 7:]], 1)


def _smoothed(walk: Walk, at: np.ndarray, near: int, poses: int) -> tuple[np.ndarray, np.ndarray]:
    """(s, 29) states at samples by local polynomials, and (28,) what the sensors' noise makes of them."""
    index = _nearest(walk, at)
    steps = np.arange(-near, near + 1)
    angle = _weights(steps * walk.step, 3)
    angles = walk.angles[at[:, None] + steps]  # s, window, 8
    window = index[:, None] + np.arange(-poses, poses + 1)
    time = (walk.seen[window] - at[:, None]) * walk.step
    here = walk.quaternion[index]
    pose = np.concatenate([walk.position[window], turn_between(here[:, None], walk.quaternion[window])], -1)  # s, window, 6
    base = np.stack([_weights(t, 2) for t in time])
    seen = np.einsum("sow,swc->soc", base, pose)
    smooth = np.einsum("ow,swc->soc", angle, angles)
    states = np.concatenate([seen[:, 0, :3], turned(here, seen[:, 0, 3:]), seen[:, 1], smooth[:, 0], smooth[:, 1]], 1)
    noise, sizes = walk.noise, np.sqrt(np.mean(np.sum(base**2, 2), 0))
    angle_sizes = np.sqrt(np.sum(angle**2, 1))
    both = np.concatenate([noise.position, noise.turn])
    sd = np.concatenate([sizes[0] * both, sizes[1] * both, angle_sizes[0] * noise.angle, angle_sizes[1] * noise.angle])
    return states, sd


def _weights(time: np.ndarray, degree: int) -> np.ndarray:
    """(2, w) weights of samples at times (w,) that give the value and the slope at zero."""
    scale = np.abs(time).max()
    rows = np.linalg.pinv(np.vander(time / scale, degree + 1, increasing=True))
    return np.stack([rows[0], rows[1] / scale])
