"""The oracle's matrices against finite differences and against MuJoCo's own (slightly soft) solution."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from mujoco_models import hip_foot, randomise, slider_rows

from hamr_sim_full.mujoco_full import full_engine, hip_rows
from hamr_sim_full.mujoco_oracle import hard_qacc, loop_bias, loop_gap, loop_jacobian, mass_matrix, motion_space


@pytest.fixture(params=["suspended", "ground"])
def robot(request):
    return full_engine(environment=request.param)


def moved(model, data, h):
    """Closure errors after h ms at constant velocity."""
    other = mujoco.MjData(model)
    other.qpos[:], other.qvel[:] = data.qpos, data.qvel
    mujoco.mj_integratePos(model, other.qpos, other.qvel, h)
    mujoco.mj_forward(model, other)
    return loop_gap(model, other)


def test_jacobian_and_bias_are_derivatives_of_the_gap(robot, rng):
    """At any velocity, not only admissible ones."""
    model, data = robot.model, robot.data
    randomise(model, data, rng)
    data.qvel[:] = rng.normal(0.0, 0.1, model.nv)
    mujoco.mj_forward(model, data)
    h = 1e-3
    there, here, back = moved(model, data, h), loop_gap(model, data), moved(model, data, -h)
    assert (there - back) / (2 * h) == pytest.approx(loop_jacobian(model, data) @ data.qvel, rel=1e-6, abs=1e-7)
    assert (there - 2 * here + back) / h**2 == pytest.approx(loop_bias(model, data), rel=1e-4, abs=1e-6)


def test_freedom_is_fourteen_or_eight(robot, rng):
    model, data = robot.model, robot.data
    for _ in range(10):
        randomise(model, data, rng)
        free = motion_space(loop_jacobian(model, data))
        assert free.shape[1] == (14 if robot.environment == "ground" else 8)
        assert np.linalg.matrix_rank(hip_rows(model) @ free) == 8, "the hip angles move freely"


def test_hard_acceleration_satisfies_closures_and_equations_of_motion(robot, rng):
    """Closures hold at acceleration level, and what is left of M a - f does no work on admissible motions (d'Alembert)."""
    model, data = robot.model, robot.data
    for _ in range(5):
        randomise(model, data, rng)
        acceleration = hard_qacc(model, data, rng.uniform(0.0, 225.0, 8))
        jacobian = loop_jacobian(model, data)
        assert np.abs(jacobian @ acceleration + loop_bias(model, data)).max() < 1e-11
        left = mass_matrix(model, data) @ acceleration - data.qfrc_smooth
        assert np.abs(motion_space(jacobian).T @ left).max() < 1e-11


def test_mujoco_itself_is_close_to_the_hard_solution(robot, rng):
    model, data = robot.model, robot.data
    hips = hip_rows(model)
    for _ in range(5):
        randomise(model, data, rng)
        if robot.environment == "ground":
            data.qpos[2] = 100.0  # out of reach of the floor
        hard = hips @ hard_qacc(model, data, rng.uniform(0.0, 225.0, 8))
        assert hips @ data.qacc == pytest.approx(hard, abs=2e-3 * np.abs(hard).max())


def test_foot_of_the_universal_joint_is_the_foot_of_the_robot(robot, rng):
    """Hip angles ql1 + ql2 and qfb3 about the hip centre place the foot exactly where HAMR-full has it."""
    model, data = robot.model, robot.data
    for _ in range(10):
        angles, _ = randomise(model, data, rng)
        base = data.body("base_link")
        turn = base.xmat.reshape(3, 3)
        for i, leg in enumerate(("fl", "rl", "fr", "rr")):
            hip = np.array([12.75465981539 * (1 if leg[0] == "f" else -1), 9.79 * (1 if leg[1] == "l" else -1), 0.46])
            expected = base.xpos + turn @ (hip + hip_foot(leg, *angles[2 * i : 2 * i + 2]))
            assert data.site(f"{leg}_foot").xpos == pytest.approx(expected, abs=1e-6)


def test_drive_torque_row_is_the_sliders_virtual_work(robot, rng):
    """torque = (d slider / d hip)^T force, with the slope from the motion space of the closed loops."""
    model, data = robot.model, robot.data
    sample = np.empty((7, 8))
    for _ in range(10):
        randomise(model, data, rng)
        data.ctrl[:] = rng.uniform(0.0, 225.0, 8)
        robot.measure(sample)
        free = motion_space(loop_jacobian(model, data))
        slope = slider_rows(model) @ free @ np.linalg.pinv(hip_rows(model) @ free)
        assert 1e3 * sample[4] == pytest.approx(slope.T @ sample[5], abs=1e-7), "N mm"
