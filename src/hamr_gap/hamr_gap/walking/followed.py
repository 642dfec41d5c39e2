"""How well starts can be known at all: a robot that is the model exactly, measured as the walk was, and followed like it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hamr_description.errors import BagError

from .left import trimmed
from .replay import Replay
from .robot import Robot
from .segments import CHANGES, Segments, segments
from .setting import Setting
from .starts import start
from .walk import Noise, Walk, joined, turned

STRETCH_MS, STRETCHES = 64.0, 24  # of what the model walks: a segment, what leads up to it, and poses to either side
COARSEST = 0.01  # of the range of the angles, by which starts may miss them beside the sensors' noise


def followable(robot: Robot, walk: Walk, length_ms: float) -> tuple[Walk, float]:
    """A walk whose readings count as no better than starts can be told, and by how much worse than the sensors that is (1 or more).

    It is 1 where starts are found, as in a trot or a pronk. It is more where the chassis turns or drives jump faster than they were
    recorded, or where readings are more exact than any fit of stiff contacts: what is missed then is missed with the right model too.

    Args:
        length_ms: of the segments.

    Raises:
        BagError: so much would be missed that the walk says nothing about any model.
    """
    own = walk_of(robot, walk)
    replay = Replay.of(robot, segments(own, length_ms=length_ms, every_ms=STRETCH_MS))
    left, _ = trimmed(start(replay, Setting()).residual[:, :-CHANGES])
    factor, noise = max(1.0, float(np.sqrt(left))), walk.noise
    share = np.sqrt(factor**2 - 1.0) * float(np.median(noise.angle / np.ptp(walk.angles, axis=0)))
    if not share < COARSEST:
        raise BagError(
            f"This walk cannot be followed: a robot that is the model exactly would miss its own angles by {100 * share:.1f} % of their "
            f"range within {length_ms:g} ms, for where each stretch starts cannot be told; let it move less abruptly (a gait with smooth "
            f"drives; a policy makes them jump), or record drives and poses more often."
        )
    return replace(walk, known=Noise(factor * noise.angle, factor * noise.position, factor * noise.turn)), factor


def walk_of(robot: Robot, walk: Walk) -> Walk:
    """What a robot as given would have shown in stretches of a walk, with the noise of its sensors (the same each time)."""
    whole = segments(walk, length_ms=STRETCH_MS, every_ms=STRETCH_MS)
    some = whole.some(np.unique(np.linspace(0, len(whole) - 1, STRETCHES).astype(int)))
    lanes, drives = np.arange(len(some)), Replay.of(robot, some).observed.drives
    runs = robot.run(some.starts, drives, [Setting()], np.zeros_like(lanes), lanes)
    rng = np.random.default_rng(0)
    ran = [k for k in lanes if all(np.isfinite(x[k]).all() for x in (runs.angles, runs.position, runs.quaternion))]
    if 2 * len(ran) < len(lanes):
        raise BagError("The model diverges under the drives of this walk: are they those of this robot, in volts?")
    own = joined([_seen(some, k, runs.angles[k], runs.position[k], runs.quaternion[k], walk.noise, rng) for k in ran])
    return replace(own, known=walk.noise)


def _seen(some: Segments, k: int, angles: np.ndarray, position: np.ndarray, quaternion: np.ndarray, noise: Noise,
          rng: np.random.Generator) -> Walk:  # fmt: skip
    """The readings of one stretch, from the sample after its start on."""
    walk, first = some.walk, some.first[k] + 1
    per, samples = len(walk.voltages) // len(walk.angles), len(angles)
    volts = walk.voltages[first * per : (first + samples) * per]
    samples = len(volts) // per
    at = walk.seen[(walk.seen >= first) & (walk.seen < first + samples)] - first
    poses = len(at), 3
    return Walk(
        volts, angles[:samples] + noise.angle * rng.standard_normal((samples, 8)), walk.step, at,
        position[at] + noise.position * rng.standard_normal(poses), turned(quaternion[at], noise.turn * rng.standard_normal(poses)),
    )  # fmt: skip
