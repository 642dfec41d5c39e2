"""Shared by the MuJoCo tests: plausible constants of HAMR-simple, random states, and the loop-closed linearisation of HAMR-full."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import mujoco
import numpy as np

from hamr_description import mjcf
from hamr_description.mjcf_full import drive_joint
from hamr_description.names import JOINTS
from hamr_sim_full.actuator import bender
from hamr_sim_full.mujoco_full import full_engine, hip_rows
from hamr_sim_full.mujoco_oracle import close_loops, loop_jacobian, mass_matrix, motion_space
from hamr_sim_residual.mujoco_published import published_engine
from hamr_sim_residual.mujoco_simple import simple_engine

#: HAMR-simple's leg as hamr_facts section 4 has it, rounded.
LEG = {
    "mass": 0.0676, "com": [0.0261, 1.0252, -1.7728], "inertia": [1.657, 1.075, 0.964, 0.185, -0.397, 0.262],
    "stiffness": [0.5019, 0.6173], "damping": [0.0365, 0.04142], "torque_per_volt": [1.528e-3, 1.672e-3], "tip_per_angle": [0.53, 0.58],
    "stop_low": [-0.67, -0.60], "stop_high": [0.56, 0.51], "stop_stiffness": [28.0, 33.5], "stop_damping": [5.6, 6.7],
}  # fmt: skip
CONSTANTS = {
    "chassis": {"mass": 1.2066, "com": [0.0, 0.0, -0.38], "inertia": [49.07, 68.1, 99.75, 0.0, 0.237, 0.0]},
    "front": LEG,
    "rear": LEG,
}
ENGINES = {"full": full_engine, "simple": partial(simple_engine, CONSTANTS), "simple_published": published_engine}


@dataclass(frozen=True)
class Reduced:
    """HAMR-full at one posture in its 8 slider coordinates: fl_swing, fl_lift, rl_swing, ...; per_slider (nv, 8)."""

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    per_slider: np.ndarray


def slider_rows(model: mujoco.MjModel) -> np.ndarray:
    """(8, nv) rows that pick the sliders."""
    rows = np.zeros((len(JOINTS), model.nv))
    rows[np.arange(len(JOINTS)), [model.joint(drive_joint(joint)).dofadr[0] for joint in JOINTS]] = 1.0
    return rows


def full_at(position=(0.0,) * 8, *, rail: bool = True) -> tuple[mujoco.MjModel, mujoco.MjData, Reduced]:
    """Suspended HAMR-full without gravity, at slider positions (8,) mm with its loops closed."""
    law = bender()
    model = mujoco.MjModel.from_xml_string(mjcf.full(c0=law.c0, c1=law.c1, environment="suspended", rail=rail, gravity=0.0))
    data = mujoco.MjData(model)
    picks = slider_rows(model)
    for part in np.linspace(0.0, 1.0, 4):
        close_loops(model, data, picks, part * np.asarray(position), np.zeros(8))
    mujoco.mj_forward(model, data)
    free = motion_space(loop_jacobian(model, data))
    per = free @ np.linalg.inv(picks @ free)
    springs = np.diag(model.jnt_stiffness) - picks.T @ np.diag(model.actuator_biasprm[:, 1]) @ picks
    reduced = Reduced(per.T @ mass_matrix(model, data) @ per, per.T @ springs @ per, per.T @ np.diag(model.dof_damping) @ per, per)
    return model, data, reduced


def randomise(model: mujoco.MjModel, data: mujoco.MjData, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Put HAMR-full into a random state with closed loops; hip angles (8,) rad and rates (8,) rad/ms."""
    mujoco.mj_resetDataKeyframe(model, data, 0)
    if model.nq > model.nv:
        turn = rng.normal(size=4)
        data.qpos[3:7] = turn / np.linalg.norm(turn)
        data.qvel[:6] = rng.normal(0.0, 0.1, 6)
    angles, rates = rng.uniform(-0.43, 0.43, 8), rng.normal(0.0, 0.1, 8)
    close_loops(model, data, hip_rows(model), angles, rates)
    mujoco.mj_forward(model, data)
    return angles, rates


def hip_foot(leg: str, swing: float, lift: float) -> np.ndarray:
    """Foot relative to the hip: Rx(lift) Rz(swing) (0, +-7.58, -13.0), mm."""
    x, y, z = 0.0, 7.58 if leg[1] == "l" else -7.58, -13.0
    c, s = np.cos(swing), np.sin(swing)
    x, y = c * x - s * y, s * x + c * y
    c, s = np.cos(lift), np.sin(lift)
    return np.array([x, c * y - s * z, s * y + c * z])
