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
CHANGES = 28
NEAR_MS = 1.5  # to either side, of the angles that a start is smoothed from
POSES = 2  # to either side, that it is smoothed from
LOOSE = 1.5  # by how many of its standard deviations a smoothed start may be off at the cost of one: neighbours are seen twice


@dataclass(frozen=True)
class Segments:
    """Stretches of a walk, each with a start of its own.

    Attributes:
        walk. first: (s,) samples at which they start; the chassis is seen there. samples: of each, the start's not counted.
        starts: (s, 29) smoothed states. sd: (28,) standard deviations of their changes, loosened.
    """

    walk: Walk
    first: np.ndarray
    samples: int
    starts: np.ndarray
    sd: np.ndarray

    def __len__(self) -> int:
        return len(self.first)

    def some(self, index: np.ndarray) -> Segments:
        """A choice of them."""
        return Segments(self.walk, self.first[index], self.samples, self.starts[index], self.sd)


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
    samples, near = round(length_ms / walk.step), round(NEAR_MS / walk.step)
    poses = [i for i in range(POSES, len(walk.seen) - POSES) if _whole(walk, i, near, samples)]
    chosen: list[int] = []
    for i in poses:
        if not chosen or (walk.seen[i] - walk.seen[chosen[-1]]) * walk.step >= every_ms - 1e-9:
            chosen.append(i)
    if len(chosen) < 8:
        raise BagError(f"The walk has {len(chosen)} segments of {length_ms:g} ms: too few to learn from; record longer.")
    index = np.array(chosen)
    starts, noise = _smoothed(walk, index, near, POSES)
    wide, _ = _smoothed(walk, index, near, POSES - 1)
    narrow, _ = _smoothed(walk, index, near // 2, POSES)
    moves = np.hypot(_apart(wide, starts).std(0), _apart(narrow, starts).std(0))  # how much the choice of neighbours matters
    return Segments(walk, walk.seen[index], samples, starts, LOOSE * np.hypot(noise, moves))


def _whole(walk: Walk, i: int, near: int, samples: int) -> bool:
    """Whether a segment from pose i, with all that smoothing needs, was recorded without a break."""
    window = walk.seen[i - POSES : i + POSES + 1]
    first, last = min(int(window[0]), walk.seen[i] - near), max(int(window[-1]), walk.seen[i] + max(near, samples))
    dense = np.diff(window).max() < 1.5 * np.median(np.diff(walk.seen))
    return dense and first >= 0 and last < len(walk.angles) and not any(first < b <= last for b in walk.breaks)


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, 28) changes from states to others."""
    return np.concatenate([b[:, :3] - a[:, :3], turn_between(a[:, QUATERNION], b[:, QUATERNION]), b[:, 7:] - a[:, 7:]], 1)


def _smoothed(walk: Walk, index: np.ndarray, near: int, poses: int) -> tuple[np.ndarray, np.ndarray]:
    """(s, 29) states at some of the poses by local polynomials, and (28,) what the sensors' noise makes of them."""
    at = walk.seen[index]
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
