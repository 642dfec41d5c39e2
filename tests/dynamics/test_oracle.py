"""The step's accelerations equal MuJoCo's, an independently written implementation, over random states."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from forward import free_acceleration, hip_acceleration

from hamr_description import mjcf
from hamr_description.names import JOINTS
from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants
from hamr_dynamics.plant import plant
from hamr_sim_full.actuator import bender
from hamr_sim_full.mujoco_full import hip_rows
from hamr_sim_full.mujoco_oracle import close_loops, hard_qacc

TOLERANCE = {"simple": 1e-9, "full": 1e-6}
NEUTRAL = value("actuator.neutral_voltage")


def model(backend: str, environment: str) -> mujoco.MjModel:
    if backend == "full":
        law = bender()
        return mujoco.MjModel.from_xml_string(mjcf.full(c0=law.c0, c1=law.c1, environment=environment))
    return mujoco.MjModel.from_xml_string(mjcf.simple(simple_constants(), environment=environment))


def hips(m: mujoco.MjModel, backend: str) -> np.ndarray:
    if backend == "full":
        return hip_rows(m)
    rows = np.zeros((8, m.nv))
    rows[range(8), [m.joint(name).dofadr[0] for name in JOINTS]] = 1.0
    return rows


@pytest.mark.parametrize("backend", ["simple", "full"])
@pytest.mark.parametrize("environment", ["suspended", "ground"])
def test_accelerations_equal_mujoco(backend, environment):
    m, robot, rng = model(backend, environment), plant(backend), np.random.default_rng(1)
    m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data, rows, gravity = mujoco.MjData(m), hips(m, backend), value("robot.gravity")
    for _ in range(25):
        mujoco.mj_resetData(m, data)
        q, v = rng.uniform(-0.4, 0.4, 8), rng.normal(0, 0.2, 8)
        volts = rng.uniform(0, 225, 8)
        if environment == "ground":
            data.qpos[:3], data.qpos[3:7] = rng.normal(0, 50, 3), rng.normal(0, 1, 4)
            data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
            data.qvel[:3], data.qvel[3:6] = rng.normal(0, 0.3, 3), rng.normal(0, 0.03, 3)
        close_loops(m, data, rows, q, v)
        truth = hard_qacc(m, data, volts)
        if environment == "suspended":
            ours, theirs = hip_acceleration(robot, q, v, volts - NEUTRAL, gravity), rows @ truth
        else:
            rotation = data.body("base_link").xmat.reshape(3, 3)
            base, ours = free_acceleration(robot, q, v, volts - NEUTRAL, rotation, data.qvel[:3], data.qvel[3:6], gravity)
            ours, theirs = np.concatenate([base[3:], base[:3], ours]), np.concatenate([truth[:6], rows @ truth])
        assert np.abs(ours - theirs).max() <= TOLERANCE[backend] * np.abs(theirs).max()
