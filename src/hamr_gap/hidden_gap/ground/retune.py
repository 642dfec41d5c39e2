"""What is left of a walk once the robot without effects is tuned again, within 20 ms, in floors of the sensor noise.

Tuned as a leg is (`retune`): drive gain, stiffness, damping, inertia and preload of each joint, its sensor's gain and bias, and one
common time shift; and the zeros of the chassis's height, roll and pitch. Pieces begin in the hidden robot's own states, or in others
that the sensors could not have told from these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hamr_description.names import BASE_FRAME, JOINTS
from hamr_description.rates import SERVO_MS

from ..machine import FACTORS, TIME_SHIFT, neutral
from ..retune import FACTOR_LEEWAY, LEEWAY, STEPS, Directions
from .laws import Scene
from .machine import EVERY, STEP, Walk, Walker
from .starts import STARTS, Starts, beside, moved, settled
from .strength import BASE, FRAME, SEGMENT, Floors, Pieces, by_channel, flat

#: Pieces looked at, and Gauss-Newton steps.
PIECES, ROUNDS = 16, 2
#: How many of a leg's steps one for a difference is: contacts bend all curves, and a chord over as much as parameters may be off leads
#: to where a tangent does not.
CHORD = 30.0
#: Parameters of the robot, whose directions need runs.
NAMES = tuple(f"{kind}.{joint}" for kind in STEPS for joint in JOINTS)
KINDS = tuple(name.split(".")[0] for name in NAMES)
IS_FACTOR = np.array([kind in FACTORS for kind in KINDS])
LEEWAYS = np.array([LEEWAY.get(kind, FACTOR_LEEWAY) for kind in KINDS])
#: Gains and biases of the angles, zeros of the base, lateness.
SENSORS = 2 * len(JOINTS) + 4
#: Zeros of the base's sensors, as columns of BASE, and how far they may wander, in floors.
ZEROS, ZERO_LEEWAY = tuple(BASE.index(f"{BASE_FRAME}_{name}") for name in ("z", "roll", "pitch")), 100.0


def left(run: Walk, changes: Mapping[str, float], volts: np.ndarray, floors: Floors, *, step: float = STEP) -> dict[str, float]:
    """Rms of what the best tuned robot without effects leaves, channel by channel: JOINTS and BASE.

    Args:
        run: with effects, under `volts` (n, 8) V. changes: the robot's own, from which it is tuned. step: of the tuned robot, ms.
    """
    given, start = Pieces.of(run, volts, floors, PIECES), _coordinates(changes)
    own, at, away = len(start), np.concatenate([start, np.zeros(SENSORS)]), np.zeros((len(given.qpos), STARTS))
    around, sensors, tried = at, _sensors(given), []
    for k in range(ROUNDS + 1):
        pieces, robot = moved(given, away), _walker(at[:own], step)
        here = pieces.missed(robot)
        columns = np.concatenate([sensors, _late(pieces, robot, here)[..., None]], axis=2)
        tried.append(here - columns @ at[own:])
        if k < ROUNDS:
            starts, every = Starts.of(pieces, robot, here), np.concatenate([_robot(pieces, at[:own], here, step), columns], axis=2)
            every, rest = beside(every, np.zeros((len(away), STARTS, len(at)))), beside(tried[-1], away)
            directions = Directions.of(starts.beyond(every).reshape(-1, len(at)), around)
            _, after, _ = directions.step(starts.beyond(rest).ravel(), at)
            away, at = away + starts.best(rest - every @ (after - at)), after
            away = settled(given, _walker(at[:own], step), columns @ at[own:], away)
    return by_channel(min(tried, key=np.linalg.norm))


def _robot(pieces: Pieces, at: np.ndarray, here: np.ndarray, step: float) -> np.ndarray:
    """(s, readings, NAMES) floors per leeway of the robot's parameters, about what is missed here (s, readings)."""
    columns = []
    for i, kind in enumerate(KINDS):
        away = CHORD * STEPS[kind] / LEEWAYS[i]
        columns.append((here - pieces.missed(_walker(at + away * (np.arange(len(at)) == i), step))) / away)
    return np.stack(columns, axis=2)


def _late(pieces: Pieces, robot: Walker, here: np.ndarray) -> np.ndarray:
    """(s, readings) likewise of voltages that come late."""
    samples = round(LEEWAY[TIME_SHIFT] / SERVO_MS)
    held = np.concatenate([np.repeat(pieces.volts[:, :1], samples, axis=1), pieces.volts[:, :-samples]], axis=1)
    return here - replace(pieces, volts=held).missed(robot)


def _sensors(pieces: Pieces) -> np.ndarray:
    """(s, readings, 19) likewise of gains and biases of the angles' sensors, and zeros of the base's."""
    angles, joints, axes = pieces.there[:, 1:, 7:] / pieces.floors.angle, np.eye(len(JOINTS)), np.eye(len(BASE))
    still, none = np.zeros((SEGMENT // EVERY // FRAME, len(BASE))), np.zeros_like(angles[0])
    columns = [np.array([flat(FACTOR_LEEWAY * each * one, still) for each in angles]) for one in joints]
    columns += [np.tile(flat(none + LEEWAY["bias"] / pieces.floors.angle * one, still), (len(angles), 1)) for one in joints]
    columns += [np.tile(flat(none, still + ZERO_LEEWAY * axes[axis]), (len(angles), 1)) for axis in ZEROS]
    return np.stack(columns, axis=2)


def _walker(at: np.ndarray, step: float) -> Walker:
    """The robot without effects at coordinates (NAMES,)."""
    x = at * LEEWAYS
    changes = dict(zip(NAMES, np.where(IS_FACTOR, np.exp(x), x).tolist(), strict=True))
    return Walker(Scene(), changes, step=step)


def _coordinates(changes: Mapping[str, float]) -> np.ndarray:
    """(NAMES,) changes in leeways, factors as logarithms."""
    x = np.array([changes.get(name, neutral(kind)) for name, kind in zip(NAMES, KINDS, strict=True)])
    x[IS_FACTOR] = np.log(x[IS_FACTOR])
    return x / LEEWAYS
