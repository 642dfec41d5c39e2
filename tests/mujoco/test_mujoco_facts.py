"""HAMR-full in MuJoCo against the published and derived facts (hamr_facts sections 1-3), each typed here from there."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from mujoco_models import full_at

from hamr_description.names import LEGS
from hamr_sim_full.actuator import bender
from hamr_sim_full.mujoco_oracle import close_loops, loop_gap

FL_SWING, FL_LIFT = np.eye(8)[0], np.eye(8)[1]


def test_total_mass():
    model, _, _ = full_at()
    assert model.body_subtreemass[0] == pytest.approx(1.47499, abs=1e-5)
    legs = [sum(model.body(f"{leg}_{link}").mass[0] for link in ("S1", "S2", "S3", "S4", "L1", "L2", "L3", "L4")) for leg in LEGS]
    assert legs == pytest.approx([0.0676, 0.0666, 0.0676, 0.0666], abs=5e-5)


def test_geometry_closes_and_feet_are_neutral():
    model, data, _ = full_at()
    data.qpos[:] = 0.0
    mujoco.mj_kinematics(model, data)
    assert np.abs(loop_gap(model, data)).max() <= 1e-5
    base = data.body("base_link").xpos
    for leg, sx, sy in (("fl", 1, 1), ("rl", -1, 1), ("fr", 1, -1), ("rr", -1, -1)):
        assert data.site(f"{leg}_foot").xpos - base == pytest.approx([sx * 12.75466, sy * 17.37, -12.54], abs=1e-5)


def test_spherical_axes_meet_at_the_hip():
    """The hinge lines of the three closures (z of s3, x of l3, y of fb2) pass through the hip centre."""
    _, data, _ = full_at()
    hip = np.array([12.75466, 9.79, 0.46])
    base = data.body("base_link").xpos
    for site, free in (("fl_s3_S3", 2), ("fl_l3_L3", 0), ("fl_fb2_S4", 1)):
        off = np.delete(data.site(site).xpos - base - hip, free)
        assert np.abs(off).max() < 1e-5, site


RATIOS = [  # joint, slider, rad per mm
    ("fl_s2", FL_SWING, 1.917),
    ("fl_fb3", FL_SWING, 1.887),
    ("fl_s1", FL_SWING, -0.030),
    ("fl_l2", FL_LIFT, 1.8305),
    ("fl_fb1", FL_LIFT, 1.724),
    ("fl_l1", FL_LIFT, -0.106),
]


@pytest.mark.parametrize(("joint", "slider", "ratio"), RATIOS)
def test_transmission_ratios_by_finite_moves(joint, slider, ratio):
    h = 1e-4
    there, back = (full_at(side * h * slider)[1].joint(joint).qpos[0] for side in (1, -1))
    assert (there - back) / (2 * h) == pytest.approx(ratio, abs=6e-4)


def test_foot_moves_per_slider_on_every_leg():
    """Foot x of swing 14.30 mm/mm (- + + -), foot y of lift 22.41 (all +) and z 13.07 (left +, right -)."""
    h = 1e-4
    for i, (leg, x_sign, z_sign) in enumerate((("fl", -1, 1), ("rl", 1, 1), ("fr", 1, -1), ("rr", -1, -1))):
        for column, expected in ((2 * i, (x_sign * 14.30, 0.0, 0.0)), (2 * i + 1, (0.0, 22.41, z_sign * 13.07))):
            there, back = (full_at(side * h * np.eye(8)[column])[1].site(f"{leg}_foot").xpos for side in (1, -1))
            assert (there - back) / (2 * h) == pytest.approx(expected, abs=0.006), (leg, column)


SWEEP = [  # slider mm, hip flexure, degrees, foot axis, mm
    (0.2 * FL_SWING, "fl_s2", 21.3, 0, -2.74),
    (-0.2 * FL_SWING, "fl_s2", -24.1, 0, 3.01),
    (0.3 * FL_SWING, "fl_s2", 32.0, 0, -4.03),
    (-0.3 * FL_SWING, "fl_s2", -39.7, 0, 4.69),
    (0.2 * FL_LIFT, "fl_l2", 19.7, 2, 3.27),
    (-0.2 * FL_LIFT, "fl_l2", -23.7, 2, -1.86),
    (0.3 * FL_LIFT, "fl_l2", 28.9, 2, 5.39),
    (-0.3 * FL_LIFT, "fl_l2", -39.5, 2, -2.01),
]


@pytest.mark.parametrize(("sliders", "joint", "degrees", "axis", "travel"), SWEEP)
def test_foot_sweep(sliders, joint, degrees, axis, travel):
    _, data, _ = full_at(sliders)
    assert np.degrees(data.joint(joint).qpos[0]) == pytest.approx(degrees, abs=0.06)
    foot = data.site("fl_foot").xpos - data.body("base_link").xpos - (12.75465981539, 17.37, -12.54)
    assert foot[axis] == pytest.approx(travel, abs=0.006)


def test_reduced_inertia_stiffness_and_damping_at_rest():
    reduced = full_at(rail=False)[2]
    assert reduced.mass[:2, :2] == pytest.approx(np.array([[3.685, -1.302], [-1.302, 5.769]]), abs=6e-4)
    assert reduced.stiffness[:2, :2] == pytest.approx(np.diag([1.4017, 1.4501]), abs=6e-5)
    assert reduced.damping[:2, :2] == pytest.approx(np.diag([0.1299, 0.1231]), abs=6e-5)
    assert np.abs(reduced.mass[:2, 2:]).max() < 1e-12, "legs of a fixed chassis are independent"


def test_inertia_changes_over_the_stroke():
    swing_out, swing_in, lift_out, lift_in = (full_at(x * axis)[2].mass for axis in (FL_SWING, FL_LIFT) for x in (-0.25, 0.25))
    found = [swing_out[0, 0], swing_in[1, 1], lift_out[1, 1], lift_in[0, 0]]
    assert found == pytest.approx([6.79, 4.91, 10.2, 3.15], rel=5e-3)


@pytest.mark.parametrize(("rail", "published"), [(False, (75.5, 108.1)), (True, (85.0, 122.0))])
def test_modes(rail, published):
    """Undamped eigenfrequencies of the loop-closed linearisation, front leg, Hz; within 1 %."""
    reduced = full_at(rail=rail)[2]
    eigenvalues = np.linalg.eigvals(np.linalg.solve(reduced.mass[:2, :2], reduced.stiffness[:2, :2])).real
    assert np.sort(1e3 * np.sqrt(eigenvalues) / (2 * np.pi)) == pytest.approx(published, rel=0.01)


def test_bender_constants():
    law = bender()
    assert law.geometry_factor == pytest.approx(1.0524, abs=5e-5)
    assert law.c0 == pytest.approx(1.4413e-3, abs=5e-8)
    assert law.c1 == pytest.approx(1.712e-3, abs=5e-7)
    assert law.stiffness == pytest.approx(1.1556, abs=5e-5)
    assert law.free_deflection == pytest.approx(0.2806, abs=5e-5)
    assert law.rail_stiffness == pytest.approx(0.385, abs=5e-4)


def test_drive_force_at_rest_and_over_the_stroke():
    """Blocked force +-0.3243 N by orientation -1 -1 +1 +1 -1 -1 +1 +1, none at neutral, -0.385 N/mm of deflection."""
    orientation = np.array([-1, -1, 1, 1, -1, -1, 1, 1])
    model, data, _ = full_at()
    for volts, force in ((0.0, 0.3243), (112.5, 0.0), (225.0, -0.3243)):
        data.ctrl[:] = volts
        mujoco.mj_forward(model, data)
        assert data.actuator_force == pytest.approx(orientation * force, abs=5e-5)
    model, data, _ = full_at(np.full(8, 0.1))
    data.ctrl[:] = 112.5
    mujoco.mj_forward(model, data)
    assert data.actuator_force == pytest.approx(np.full(8, -0.0385), abs=5e-5)
    without_rail, data, _ = full_at(np.full(8, 0.1), rail=False)
    data.ctrl[:] = 112.5
    mujoco.mj_forward(without_rail, data)
    assert np.abs(data.actuator_force).max() < 1e-15


def test_static_travel():
    """0..225 V moves the sliders +-0.181 / +-0.177 mm (linearised)."""
    reduced = full_at()[2]
    travel = np.linalg.solve(reduced.stiffness, np.full(8, 0.3243))
    assert travel[:2] == pytest.approx([0.181, 0.177], abs=6e-4)


def test_impossible_posture_is_refused():
    model, data, _ = full_at()
    reach = np.zeros((1, model.nv))
    reach[0, model.joint("fl_swing_slider").dofadr[0]] = 1.0
    with pytest.raises(ValueError, match="do not close"):
        close_loops(model, data, reach, np.array([5.0]), np.zeros(1))
