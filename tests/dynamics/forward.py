"""Accelerations of a plant from the step's own pure functions on plain numbers: the step in the limit of no duration."""

from __future__ import annotations

import numpy as np

from hamr_description.names import LEGS, joint_signs
from hamr_dynamics.batch import DRIVE_SIGN, SIGN
from hamr_dynamics.chassis_stages import mirror, mirror_spin
from hamr_dynamics.step import ROW6, LegState, chassis_terms, leg_increment, reach_leg, solve6, step_suspended

INSTANT = 1e-12  # ms
NO_GROUND = {"friction": 0.0, "stiffness": 0.0, "damping": 0.0, "slip_speed": 1.0}


def hip_acceleration(plant, q, v, drive, gravity=0.0):
    """(8,) rad/ms^2 of a suspended robot at q, v (8,) and volts from neutral (8,)."""
    out = np.zeros(8)
    for i, leg in enumerate(LEGS):
        at = slice(2 * i, 2 * i + 2)
        state = LegState(tuple(q[at] * SIGN[at]), tuple(v[at] * SIGN[at]), (0.0, 0.0))
        new, _ = step_suspended(plant.leg, state, tuple(drive[at] * DRIVE_SIGN[at]), plant.parameters(leg), gravity, INSTANT)
        out[at] = np.array(new.a, float) * SIGN[at]
    return out


def free_acceleration(plant, q, v, drive, rotation, velocity, omega, gravity):
    """((6,) angular [chassis axes] and linear [world] acceleration, (8,) hip accelerations) of a robot in the air."""
    up, body_velocity = rotation[2], rotation.T @ velocity
    chassis = plant.chassis
    matrix, rhs = chassis_terms(
        chassis["mass"], tuple(chassis["com"]), tuple(chassis["inertia"]), tuple(omega), tuple(up * gravity), INSTANT
    )
    matrix, rhs, reaches = np.array(matrix, float), np.array(rhs, float), []
    for i, leg in enumerate(LEGS):
        at = slice(2 * i, 2 * i + 2)
        state = LegState(tuple(q[at] * SIGN[at]), tuple(v[at] * SIGN[at]), (0.0, 0.0))
        base = {name: mirror_spin(leg, omega) for name in ("omega", "omega_mid")}
        base |= {"velocity": mirror(leg, body_velocity), "normal": mirror(leg, up), "height": 1e3, "gravity": gravity}
        r = reach_leg(plant.leg, state, tuple(drive[at] * DRIVE_SIGN[at]), plant.parameters(leg), base, NO_GROUND, INSTANT)
        signs = np.array([*mirror_spin(leg, (1.0,) * 3), *mirror(leg, (1.0,) * 3)])
        matrix = matrix + np.array([signs[a] * signs[b] for a, b in ROW6]) * np.array(r.free_matrix, float)
        rhs = rhs + signs * np.array(r.free_rhs, float)
        reaches.append((r, signs))
    increment = np.array(solve6(tuple(matrix), tuple(rhs)), float)
    hips = [np.array(leg_increment(r.free_own, r.free_gain, tuple(signs * increment)), float) for r, signs in reaches]
    hips = np.concatenate([h * [*joint_signs(leg)] for h, leg in zip(hips, LEGS, strict=True)])
    return np.concatenate([increment[:3], rotation @ increment[3:]]) / INSTANT, hips / INSTANT
