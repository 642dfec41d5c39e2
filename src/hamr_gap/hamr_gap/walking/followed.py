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
LOST = 3.0  # rms in noise that fitted starts may leave of the model itself: even walks leave 0.9 to 1.3, uneven ones 2


def followed(robot: Robot, walk: Walk, length_ms: float) -> float:
    """Mean square, in units of the noise, by which segments miss readings that the model itself made under the walk's drives.

    It is that of the noise where starts are found. It is far more where the chassis turns or drives jump faster than they were recorded:
    then feet start where nobody knows, and no name would mean anything.

    Args:
        length_ms: of the segments.

    Raises:
        BagError: so much is left that the walk says nothing about any model.
    """
    own = walk_of(robot, walk)
    replay = Replay.of(robot, segments(own, length_ms=length_ms, every_ms=STRETCH_MS))
    left, _ = trimmed(start(replay, Setting()).residual[:, :-CHANGES])
    if not left < LOST**2:
        raise BagError(
            f"This walk cannot be followed: a robot that is the model exactly would miss its own readings by {np.sqrt(left):.0f} times the "
            f"noise within {length_ms:g} ms, for where each stretch starts cannot be told; let it move less abruptly (a gait with smooth "
            f"drives; a policy makes them jump), or record drives and poses more often."
        )
    return left


def walk_of(robot: Robot, walk: Walk) -> Walk:
    """What a robot as given would have shown in stretches of a walk, with the noise of its sensors (the same each time)."""
    whole = segments(walk, length_ms=STRETCH_MS, every_ms=STRETCH_MS)
    some = whole.some(np.unique(np.linspace(0, len(whole) - 1, STRETCHES).astype(int)))
    lanes, drives = np.arange(len(some)), Replay.of(robot, some).observed.drives
    runs = robot.run(some.starts, drives, [Setting()], np.zeros_like(lanes), lanes)
    rng = np.random.default_rng(0)
    ran = [k for k in lanes if all(np.isfinite(x[k]).all() for x in (runs.angles, runs.position, runs.quaternion))]
    if not ran:
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
