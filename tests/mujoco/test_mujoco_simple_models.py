"""HAMR-simple and the published lumped fit in MuJoCo against their own formulas."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mujoco_models import CONSTANTS, LEG, hip_foot

from hamr_description import mjcf
from hamr_description.names import JOINTS, LEGS, MIRROR, joint_signs
from hamr_description.simple_constants import simple_constants
from hamr_sim_full.mujoco_oracle import hard_qacc, mass_matrix
from hamr_sim_residual.mujoco_published import hips, published_engine
from hamr_sim_residual.mujoco_simple import simple_engine

REST = 0.520967
SHAPE = (np.sin(REST), -np.cos(REST), REST)  # direction of the foot at rest, rest lift
angle = st.floats(-0.4, 0.4)
rate = st.floats(-1.0, 1.0)
_model = mujoco.MjModel.from_xml_string(mjcf.simple(CONSTANTS, environment="suspended"))
SUSPENDED = (_model, mujoco.MjData(_model))


def test_shipped_constants_make_a_model():
    """A rigid body has no principal moment above the sum of the other two; MuJoCo refuses any other."""
    engine = simple_engine()
    assert engine.model.body_subtreemass[0] == pytest.approx(1.47499, abs=1e-5)
    assert set(simple_constants()) == {"chassis", "front", "rear"}


def test_simple_is_the_derived_pendulum():
    """Mass matrix, spring, damper and torque of one leg by the parallel-axis theorem."""
    model = mujoco.MjModel.from_xml_string(mjcf.simple(CONSTANTS, environment="suspended", gravity=0.0))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    leg = LEG
    x, y, z = leg["com"]
    ixx, _, izz, _, ixz, _ = leg["inertia"]
    expected = [[izz + leg["mass"] * (x * x + y * y), ixz - leg["mass"] * x * z], [0, ixx + leg["mass"] * (y * y + z * z)]]
    dofs = [model.joint(name).dofadr[0] for name in ("fl_swing", "fl_lift")]
    found = mass_matrix(model, data)[np.ix_(dofs, dofs)]
    assert np.triu(found) == pytest.approx(np.array(expected), rel=1e-12)
    data.qpos[dofs] = 0.1, -0.2
    data.ctrl[:] = 112.5
    data.ctrl[:2] = 122.5, 102.5
    mujoco.mj_forward(model, data)
    force = data.qfrc_passive[dofs] + data.qfrc_actuator[dofs]
    torque = np.multiply(leg["torque_per_volt"], (10.0, -10.0))
    assert force == pytest.approx(torque - np.multiply(leg["stiffness"], (0.1, -0.2)), rel=1e-12)


@given(values=st.lists(angle, min_size=8, max_size=8))
def test_simple_foot_is_the_universal_joint(values):
    model, data = SUSPENDED
    for joint, q in zip(JOINTS, values, strict=True):
        data.joint(joint).qpos[0] = q
    mujoco.mj_kinematics(model, data)
    for i, leg in enumerate(LEGS):
        foot = data.site(f"{leg}_foot").xpos - data.body(f"{leg}_leg").xpos
        assert foot == pytest.approx(hip_foot(leg, *values[2 * i : 2 * i + 2]), abs=1e-12)


def test_hard_acceleration_without_loops_is_mujocos(rng):
    model = mujoco.MjModel.from_xml_string(mjcf.simple(CONSTANTS))
    data = mujoco.MjData(model)
    data.qpos[2] = 100.0
    data.qpos[7:], data.qvel[:] = rng.uniform(-0.4, 0.4, 8), rng.normal(0.0, 0.1, model.nv)
    acceleration = hard_qacc(model, data, rng.uniform(0.0, 225.0, 8))
    assert acceleration == pytest.approx(data.qacc, rel=1e-9, abs=1e-12)


def test_published_fit_modes_mass_and_feet():
    """Uncoupled 95 Hz swing and 102 Hz lift (hamr_facts section 4); feet where HAMR-full has them."""
    model = mujoco.MjModel.from_xml_string(mjcf.simple_published(environment="suspended", gravity=0.0))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    dofs = [model.joint(name).dofadr[0] for name in ("fl_swing_hinge", "fl_lift_hinge")]
    inertia = np.diag(mass_matrix(model, data))[dofs]
    assert 1e3 * np.sqrt(model.jnt_stiffness[dofs] / inertia) / (2 * np.pi) == pytest.approx([95, 102], abs=0.6)
    assert model.body_subtreemass[0] == pytest.approx(1.2066 + 2 * (0.06662764 + 0.06645694) + 4e-4)
    for leg in LEGS:
        foot = data.site(f"{leg}_foot").xpos - data.body("base_link").xpos
        assert foot == pytest.approx((*np.multiply(MIRROR[leg], (12.75466, 17.37)), -12.54), abs=1e-4)


@given(yaw=angle, roll=angle)
def test_hip_angles_point_the_foot_where_yaw_and_roll_do(yaw, roll):
    swing, lift = hips(yaw, roll, 0.0, 0.0, 0.0, 0.0, SHAPE)[:2]
    own = (-np.sin(yaw) * np.cos(roll + SHAPE[2]), np.sin(roll + SHAPE[2]), -np.cos(yaw) * np.cos(roll + SHAPE[2]))
    side = np.cos(swing) * SHAPE[0]
    project = (-np.sin(swing) * SHAPE[0], np.cos(lift) * side - np.sin(lift) * SHAPE[1], np.sin(lift) * side + np.cos(lift) * SHAPE[1])
    assert project == pytest.approx(own, abs=1e-12)


@given(yaw=angle, roll=angle, yaw_rate=rate, roll_rate=rate, yaw_acceleration=rate, roll_acceleration=rate)
def test_hip_rates_and_accelerations_are_derivatives(yaw, roll, yaw_rate, roll_rate, yaw_acceleration, roll_acceleration):
    def at(t):
        return np.array(
            hips(
                yaw + yaw_rate * t + yaw_acceleration * t * t / 2, roll + roll_rate * t + roll_acceleration * t * t / 2,
                yaw_rate + yaw_acceleration * t, roll_rate + roll_acceleration * t, yaw_acceleration, roll_acceleration, SHAPE,
            )
        )  # fmt: skip

    h = 1e-4
    here, change = at(0.0), (at(h) - at(-h)) / (2 * h)
    assert change[:4] == pytest.approx(here[2:], rel=1e-5, abs=1e-5)


def test_published_engine_reads_the_mirrored_leg_frame():
    """The same own angles in every mirrored leg are the same hip angles up to the joints' mirror signs."""
    engine = published_engine(environment="suspended")
    for leg in LEGS:
        sx, sy = MIRROR[leg]
        engine.data.joint(f"{leg}_swing_hinge").qpos[0] = sx * 0.2
        engine.data.joint(f"{leg}_lift_hinge").qpos[0] = sy * -0.1
    sample = np.empty((7, 8))
    engine.measure(sample)
    legs = (sample[0].reshape(4, 2) * [joint_signs(leg) for leg in LEGS]).tolist()
    assert legs == pytest.approx(np.tile(hips(0.2, -0.1, 0.0, 0.0, 0.0, 0.0, SHAPE)[:2], (4, 1)), abs=1e-6)
    assert np.sign(legs[0]).tolist() == [1.0, -1.0]
