"""The published lumped fit in MuJoCo: own hinges (yaw about y, then roll about x), read as the project's hip angles.

Both pairs of angles are tied by the direction from hip to foot, so that state, targets and stops mean the same on every backend.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numba import njit

from hamr_description import mjcf, units
from hamr_description.mjcf_simple import published_hinge
from hamr_description.names import JOINTS, LEGS, MIRROR
from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants
from hamr_sim_full.mujoco_engine import MujocoEngine, stop_force

from .mujoco_simple import fill_drive, joint_stops, tips_per_angle


def published_engine(*, environment: str = "ground", friction: float | None = None, gravity: float | None = None) -> MujocoEngine:
    """The published lumped fit. Arguments as `hamr_description.mjcf.full`."""
    xml = mjcf.simple_published(environment=environment, friction=friction, gravity=gravity)
    return MujocoEngine(xml, PublishedReadout, backend="simple_published", environment=environment)


class PublishedReadout:
    """Hip angles (swing about z after lift about x) of the direction in which yaw and roll point the foot.

    End stops and tips are HAMR-simple's.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._state = (data.qpos[model.nq - model.nv :], data.qvel, data.qacc)
        self._ctrl, self._applied = data.ctrl, data.qfrc_applied
        self._dofs = np.array([model.joint(published_hinge(joint)).dofadr[0] for joint in JOINTS])
        self._law = np.stack([model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 0]])
        self._signs = np.array([MIRROR[leg] for leg in LEGS], float)
        rest = value("simple_published.rest_lift")
        self._shape = np.array([np.sin(rest), -np.cos(rest), rest])
        self._stops = joint_stops(simple_constants())
        self._tips = tips_per_angle(simple_constants())
        self._torque = np.empty(len(JOINTS))

    def push_stops(self) -> int:
        """See `Readout`."""
        q, v, _ = self._state
        return _push(q, v, self._dofs, self._signs, self._shape, self._stops, self._applied)

    def measure(self, sample: np.ndarray) -> None:
        """See `Readout`."""
        _measure(*self._state, self._ctrl, self._dofs, self._signs, self._shape, self._law, self._torque, sample)
        sample[1] = units.rate_to_si(sample[1])
        sample[6] = units.rate_to_si(units.rate_to_si(sample[6]))
        fill_drive(sample, self._torque, self._tips)


@njit(cache=True)
def _turn(p, p1, p2):
    """Rate and acceleration of the angle of a plane vector p with rate p1 and acceleration p2."""
    square = p[0] * p[0] + p[1] * p[1]
    rate = (p[0] * p1[1] - p[1] * p1[0]) / square
    return rate, (p[0] * p2[1] - p[1] * p2[0] - 2.0 * rate * (p[0] * p1[0] + p[1] * p1[1])) / square


@njit(cache=True)
def hips(yaw, roll, yaw_rate, roll_rate, yaw_acceleration, roll_acceleration, shape):
    """(swing, lift), rates and accelerations (6 values) of own angles, front-left leg's frame.

    shape: y and z of the direction from hip to foot at rest, and the roll at rest.
    """
    y, z, rest = shape
    s, c, sr, cr = np.sin(yaw), np.cos(yaw), np.sin(roll + rest), np.cos(roll + rest)
    d0, d = -s * cr, (sr, -c * cr)  # direction to the foot: x, and (y, z)
    d0_1, d_1 = s * sr * roll_rate - c * cr * yaw_rate, (cr * roll_rate, s * cr * yaw_rate + c * sr * roll_rate)
    square = yaw_rate * yaw_rate + roll_rate * roll_rate
    twice = 2.0 * yaw_rate * roll_rate
    d0_2 = s * sr * roll_acceleration - c * cr * yaw_acceleration + s * cr * square + c * sr * twice
    d_2 = (
        cr * roll_acceleration - sr * roll_rate * roll_rate,
        s * cr * yaw_acceleration + c * sr * roll_acceleration + c * cr * square - s * sr * twice,
    )
    swing = np.arcsin(-d0 / y)
    sb, cb = np.sin(swing), np.cos(swing)
    swing_rate = -d0_1 / (y * cb)
    swing_acceleration = (sb * swing_rate * swing_rate - d0_2 / y) / cb
    b, b_1 = (y * cb, z), (-y * sb * swing_rate, 0.0)  # what the lift turns onto d
    b_2 = (-y * (sb * swing_acceleration + cb * swing_rate * swing_rate), 0.0)
    lift = np.arctan2(d[1], d[0]) - np.arctan2(b[1], b[0])
    to, fro = _turn(d, d_1, d_2), _turn(b, b_1, b_2)
    return swing, lift, swing_rate, to[0] - fro[0], swing_acceleration, to[1] - fro[1]


@njit(cache=True)
def _leg(q, v, a, swing, lift, sign, shape):
    """`hips` of one leg from its dofs, and d(swing, lift)/d(yaw, roll) as (ss, sl, ls, ll)."""
    sx, sy = sign
    yaw, roll = sx * q[swing], sy * q[lift]
    state = hips(yaw, roll, sx * v[swing], sy * v[lift], sx * a[swing], sy * a[lift], shape)
    by_yaw, by_roll = hips(yaw, roll, 1.0, 0.0, 0.0, 0.0, shape), hips(yaw, roll, 0.0, 1.0, 0.0, 0.0, shape)
    return state, (by_yaw[2], by_roll[2], by_yaw[3], by_roll[3])


@njit(cache=True)
def _push(q, v, dofs, signs, shape, stops, applied):
    hits = 0
    for leg in range(len(signs)):
        i, k = dofs[2 * leg], dofs[2 * leg + 1]
        sx, sy = signs[leg]
        state, slope = _leg(q, v, v, i, k, signs[leg], shape)
        a, b = stops[2 * leg], stops[2 * leg + 1]
        swing = sx * sy * stop_force(sx * sy * state[0], sx * sy * state[2], a[0], a[1], a[2], a[3])
        lift = sy * stop_force(sy * state[1], sy * state[3], b[0], b[1], b[2], b[3])
        applied[i] = sx * (slope[0] * swing + slope[2] * lift)
        applied[k] = sy * (slope[1] * swing + slope[3] * lift)
        hits += (swing != 0) + (lift != 0)
    return hits


@njit(cache=True)
def _measure(q, v, a, ctrl, dofs, signs, shape, law, torque, sample):
    """Hip rows in inside units and the drive's hip torques, N mm."""
    for leg in range(len(signs)):
        i, k = 2 * leg, 2 * leg + 1
        sx, sy = signs[leg]
        state, slope = _leg(q, v, a, dofs[i], dofs[k], signs[leg], shape)
        for row, n in ((0, 0), (1, 2), (6, 4)):
            sample[row, i], sample[row, k] = sx * sy * state[n], sy * state[n + 1]
        about_y = sx * (law[0, i] * ctrl[i] + law[1, i])
        about_x = sy * (law[0, k] * ctrl[k] + law[1, k])
        scale = slope[0] * slope[3] - slope[1] * slope[2]
        torque[i] = sx * sy * (slope[3] * about_y - slope[2] * about_x) / scale
        torque[k] = sy * (slope[0] * about_x - slope[1] * about_y) / scale
