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

from .case import Effect
from .ground_laws import Scene, scene
from .ground_machine import EVERY, SAMPLE_HZ, STEP, Walk, Walker

#: Servo samples of a segment; segments compared at most; samples per frame of motion capture; cosine of the roll and pitch of a fall.
SEGMENT, SEGMENTS, FRAME, FALLEN = SERVO_HZ // 50, 200, SAMPLE_HZ // TARGET_HZ, 0.5
BASE = tuple(f"{BASE_FRAME}_{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw"))


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


def shown(run: Walk, changes: Mapping[str, float], volts: np.ndarray, floors: Floors, *, step: float = STEP) -> dict[str, float]:
    """Rms, in floors, of a run minus the runs of 20 ms without effects from its states, channel by channel: JOINTS and BASE."""
    plain, count, squares = Walker(Scene(), changes, step=step), len(run.mark_qpos), []
    for k in np.unique(np.linspace(0, count - 1, min(count, SEGMENTS)).round().astype(int)):
        plain.set(run.mark_qpos[k], run.mark_qvel[k])
        first = k * SEGMENT
        found = plain.run(volts[first : first + SEGMENT + 1]).qpos
        there = run.qpos[first // EVERY : first // EVERY + len(found)]
        base = difference(there[FRAME::FRAME], found[FRAME::FRAME]) / np.repeat([floors.position, floors.orientation], 3)
        squares.append(np.r_[np.mean(((there - found)[1:, 7:] / floors.angle) ** 2, axis=0), np.mean(base**2, axis=0)])
    return dict(zip((*JOINTS, *BASE), np.sqrt(np.mean(squares, axis=0)).tolist(), strict=True))


def difference(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n, 6) positions (m) and rotation vectors (rad) of poses (n, 7+) less those of others, near by."""
    a, b = (x[:, 3:7] / np.linalg.norm(x[:, 3:7], axis=1, keepdims=True) for x in (one, other))
    turned = 2.0 * (b[:, :1] * a[:, 1:] - a[:, :1] * b[:, 1:] - np.cross(b[:, 1:], a[:, 1:]))
    return np.hstack([length_to_si(one[:, :3] - other[:, :3]), turned])
