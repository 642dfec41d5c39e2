"""HAMR-full in MuJoCo: where hip angles, tips and end stops lie in its 8 coordinates per leg."""

from __future__ import annotations

import mujoco
import numpy as np
from numba import njit

from hamr_description import mjcf, units
from hamr_description.mjcf_full import CHAINS, hip_joints
from hamr_description.names import AXES, JOINTS, LEGS, MIRROR
from hamr_description.numbers import value

from .actuator import bender
from .mujoco_engine import MujocoEngine, stop_force

COORDINATES = tuple(joint for axis in AXES for joint, _ in CHAINS[axis])
SWING_SLIDER, S1, S2, FB1, LIFT_SLIDER, L1, L2, FB3 = range(len(COORDINATES))


def full_engine(*, environment: str = "ground", friction: float | None = None, gravity: float | None = None) -> MujocoEngine:
    """HAMR-full as published, with loop closures. Arguments as `hamr_description.mjcf.full`."""
    law = bender()
    xml = mjcf.full(c0=law.c0, c1=law.c1, environment=environment, friction=friction, gravity=gravity)
    return MujocoEngine(xml, FullReadout, backend="full", environment=environment)


def hip_rows(model: mujoco.MjModel) -> np.ndarray:
    """(8, nv): hip angles in names.JOINTS order from the model's dofs."""
    rows = np.zeros((len(JOINTS), model.nv))
    for row, joint in zip(rows, JOINTS, strict=True):
        row[[model.joint(name).dofadr[0] for name in hip_joints(joint)]] = 1.0
    return rows


class FullReadout:
    """Hip angles: swing = fb3, lift = l1 + l2. Tips: the sliders, along +y of the chassis."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._state = (data.qpos[model.nq - model.nv :], data.qvel, data.qacc)  # qpos as long as qvel: the base's first number is cut off
        self._ctrl, self._applied = data.ctrl, data.qfrc_applied
        self._dofs = np.array([[model.joint(f"{leg}_{name}").dofadr[0] for name in COORDINATES] for leg in LEGS])
        self._signs = np.array([MIRROR[leg] for leg in LEGS], float)
        self._law = np.stack([model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 0], model.actuator_biasprm[:, 1]])
        self._cranks = np.array([value("leg.closures.s3")[1][:2], value("leg.closures.l3")[1][1:]])
        self._stop = np.array([value(f"actuator.{name}") for name in ("stop", "stop_stiffness", "stop_damping")])

    def push_stops(self) -> int:
        """See `Readout`."""
        q, v, _ = self._state
        return _push(q, v, self._dofs, self._stop, self._applied)

    def measure(self, sample: np.ndarray) -> None:
        """See `Readout`."""
        _measure(*self._state, self._ctrl, self._dofs, self._signs, self._law, self._cranks, sample)


@njit(cache=True)
def _push(q, v, dofs, stop, applied):
    hits = 0
    for leg in range(len(dofs)):
        for slider in (SWING_SLIDER, LIFT_SLIDER):
            i = dofs[leg, slider]
            applied[i] = stop_force(q[i], v[i], -stop[0], stop[0], stop[1], stop[2])
            hits += applied[i] != 0
    return hits


@njit(cache=True)
def _measure(q, v, a, ctrl, dofs, signs, law, cranks, sample):
    for leg in range(len(dofs)):
        d = dofs[leg]
        for row, x, unit in ((0, q, 1.0), (1, v, units.MS_PER_S), (6, a, units.MS_PER_S**2)):
            sample[row, 2 * leg] = unit * x[d[FB3]]
            sample[row, 2 * leg + 1] = unit * (x[d[L1]] + x[d[L2]])
        for k, slider in ((2 * leg, d[SWING_SLIDER]), (2 * leg + 1, d[LIFT_SLIDER])):
            sample[2, k] = q[slider] / units.MM_PER_M
            sample[3, k] = v[slider] / units.MM_PER_M * units.MS_PER_S
            sample[5, k] = law[0, k] * ctrl[k] + law[1, k] + law[2, k] * q[slider]
        swing, lift = _hip_torques(q, d, sample[5, 2 * leg], sample[5, 2 * leg + 1], signs[leg], cranks)
        sample[4, 2 * leg] = swing / units.MM_PER_M
        sample[4, 2 * leg + 1] = lift / units.MM_PER_M


@njit(cache=True)
def _hip_torques(q, d, swing_force, lift_force, sign, cranks):
    """Hip torques (swing, lift), N mm, of slider forces, N: (d slider / d hip)^T F, in the front-left leg's frame and back.

    Each slider drives its crank (S3 about z, L3 about x) as a planar slider-crank; with the cranks at yaw psi and roll phi and
    the leg at swing beta, tan(psi) = tan(beta) / cos(phi).
    """
    about_x, about_z = sign[1], sign[0] * sign[1]
    sigma, psi = about_z * q[d[S1]], about_z * (q[d[S1]] + q[d[S2]])
    lam, phi, beta = about_x * q[d[L1]], about_x * (q[d[L1]] + q[d[L2]]), about_z * q[d[FB3]]
    x, y = cranks[0]
    per_psi = -np.tan(sigma) * (np.sin(psi) * x + np.cos(psi) * y) - (np.cos(psi) * x - np.sin(psi) * y)
    y, z = cranks[1]
    per_phi = -np.tan(lam) * (np.cos(phi) * y - np.sin(phi) * z) + np.sin(phi) * y + np.cos(phi) * z
    scale = (np.cos(beta) * np.cos(phi)) ** 2 + np.sin(beta) ** 2
    about_yaw = sign[1] * swing_force * per_psi
    swing = about_yaw * np.cos(phi) / scale
    lift = about_yaw * np.sin(beta) * np.cos(beta) * np.sin(phi) / scale + sign[1] * lift_force * per_phi
    return about_z * swing, about_x * lift
