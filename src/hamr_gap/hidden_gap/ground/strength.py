"""How much of an effect shows in 20 ms: contact is chaotic, so runs with and without it are compared from the same states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hamr_bags.as_measured import strokes
from hamr_description.errors import ModelError
from hamr_description.names import BASE_FRAME, JOINTS, Topic
from hamr_description.rates import SERVO_HZ, TARGET_HZ
from hamr_description.units import length_to_si

from ..case import Effect
from .laws import Scene, scene
from .machine import EVERY, SAMPLE_HZ, STEP, Walk, Walker

#: Servo samples of a segment; segments compared at most; samples per frame of motion capture; cosine of the roll and pitch of a fall.
SEGMENT, SEGMENTS, FRAME, FALLEN = SERVO_HZ // 50, 200, SAMPLE_HZ // TARGET_HZ, 0.5
BASE = tuple(f"{BASE_FRAME}_{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw"))
#: Readings of a segment's hip angles.
ANGLES = SEGMENT // EVERY * len(JOINTS)


@dataclass(frozen=True, slots=True)
class Floors:
    """Standard deviations of the sensor noise: hip angles (rad), position (m), orientation (rad)."""

    angle: float
    position: float
    orientation: float

    @classmethod
    def of(cls, noise: float, position: float, orientation: float) -> Floors:
        """`noise`: share of the encoders' stroke."""
        return cls(noise * strokes()[Topic.SERVO_JOINTS], position, orientation)


def walked(effects: tuple[Effect, ...], changes: Mapping[str, float], volts: np.ndarray, *, step: float = STEP) -> Walk:
    """The run from the stand, under voltages (n, 8) V; ModelError if it diverges or the robot falls over."""
    run = Walker(scene(effects), changes, step=step).run(volts, range(0, len(volts) - SEGMENT, SEGMENT))
    _, x, y, _ = (run.qpos[:, 3:7] / np.linalg.norm(run.qpos[:, 3:7], axis=1, keepdims=True)).T
    if np.min(1.0 - 2.0 * (x * x + y * y)) < FALLEN:
        raise ModelError("the hidden robot falls over; draw another seed.")
    return run


@dataclass(frozen=True, slots=True)
class Pieces:
    """Stretches of 20 ms of a run, each beginning in a state of it.

    Attributes:
        qpos, qvel: (s, .) the states. volts: (s, SEGMENT + 1, 8) V. there: (s, rows, 15) the run's coordinates at 4 kHz. floors.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    volts: np.ndarray
    there: np.ndarray
    floors: Floors

    @classmethod
    def of(cls, run: Walk, volts: np.ndarray, floors: Floors, most: int = SEGMENTS) -> Pieces:
        """At most so many, evenly spread over a run under voltages (n, 8) V."""
        chosen = np.unique(np.linspace(0, len(run.mark_qpos) - 1, min(len(run.mark_qpos), most)).round().astype(int))
        held = np.stack([volts[k * SEGMENT : (k + 1) * SEGMENT + 1] for k in chosen])
        rows = np.arange(-(-held.shape[1] // EVERY))
        there = np.stack([run.qpos[k * SEGMENT // EVERY + rows] for k in chosen])
        return cls(run.mark_qpos[chosen], run.mark_qvel[chosen], held, there, floors)

    def missed(self, plain: Walker) -> np.ndarray:
        """(s, readings) by which another robot misses them from the same states, in floors."""
        missed = []
        for qpos, qvel, volts, there in zip(self.qpos, self.qvel, self.volts, self.there, strict=True):
            plain.set(qpos, qvel)
            found = plain.run(volts).qpos
            base = difference(there[FRAME::FRAME], found[FRAME::FRAME]) / np.repeat([self.floors.position, self.floors.orientation], 3)
            missed.append(flat((there - found)[1:, 7:] / self.floors.angle, base))
        return np.array(missed)


def flat(angles: np.ndarray, base: np.ndarray) -> np.ndarray:
    """(ANGLES + poses,) readings of a piece: hip angles (rows, 8), then the base at each frame (frames, 6)."""
    return np.concatenate([angles.ravel(), base.ravel()])


def by_channel(missed: np.ndarray) -> dict[str, float]:
    """Rms of (s, readings) as of `Pieces.missed`, channel by channel: JOINTS and BASE."""
    angles, base = missed[:, :ANGLES].reshape(-1, len(JOINTS)), missed[:, ANGLES:].reshape(-1, len(BASE))
    rms = np.sqrt(np.concatenate([np.mean(angles**2, axis=0), np.mean(base**2, axis=0)]))
    return dict(zip((*JOINTS, *BASE), rms.tolist(), strict=True))


def shown(run: Walk, changes: Mapping[str, float], volts: np.ndarray, floors: Floors, *, step: float = STEP) -> dict[str, float]:
    """Rms, in floors, of a run minus the runs of 20 ms without effects from its states, channel by channel: JOINTS and BASE."""
    return by_channel(Pieces.of(run, volts, floors).missed(Walker(Scene(), changes, step=step)))


def difference(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n, 6) positions (m) and rotation vectors (rad) of poses (n, 7+) less those of others, near by."""
    a, b = (x[:, 3:7] / np.linalg.norm(x[:, 3:7], axis=1, keepdims=True) for x in (one, other))
    turned = 2.0 * (b[:, :1] * a[:, 1:] - a[:, :1] * b[:, 1:] - np.cross(b[:, 1:], a[:, 1:]))
    return np.hstack([length_to_si(one[:, :3] - other[:, :3]), turned])
