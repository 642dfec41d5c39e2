"""The hidden machine without a law is MuJoCo's, its steps are small enough, and its parts are where they should be."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from hamr_bags.as_measured import strokes
from hamr_bags.excitation import excitation
from hamr_description import mjcf
from hamr_description.names import Topic
from hamr_description.simple_constants import simple_constants
from hidden_gap.case import JOINTS, Effect
from hidden_gap.conditions import NOISE
from hidden_gap.laws.law import LAWS
from hidden_gap.machine import machine, rest_mass
from hidden_gap.simulate import EVERY, commands, play

QUIET = {"kind": "noise", "seconds": 0.4, "seed": 3, "std": 40.0}
LOUD = {"kind": "noise", "seconds": 3.0, "seed": 3}
FRONT = simple_constants()["front"]


def _effect(name: str, joints=JOINTS[:1], **parameters: float) -> Effect:
    law = LAWS[name]
    return Effect(law.family, tuple(joints), name, {key: (low if low > 0 else 0.0) for key, (low, _) in law.ranges.items()} | parameters)


def test_without_a_law_it_is_plain_mujoco_bit_for_bit():
    """A Python loop around mj_step; MuJoCo's rates and its Coriolis forces, carried half a step on, as the loop does."""
    leg, step = machine({}, step=0.025), 0.025
    model, data, volts = leg.model, leg.data, commands(**QUIET)
    bias, change = np.zeros(2), np.zeros(2)
    states, reached = [], 0.0
    for k, volt in enumerate(volts):
        for part in range(2):
            states.append(data.qpos[leg.dofs].copy())
            reached = max(reached, np.abs(states[-1]).max())
            data.ctrl[:] = (volt - 112.5) + 112.5
            data.qfrc_applied[leg.dofs] = -0.5 * change[leg.dofs]
            mujoco.mj_step(model, data)
            change = data.qfrc_bias - bias if k + part else np.zeros(2)
            bias = data.qfrc_bias.copy()
    states = np.array(states)
    mean = 0.5 * (states + np.vstack([states[:1], states[:-1]]))
    assert 0.2 < reached < 0.45  # moves, and stays clear of the end stops
    assert step * 2 * len(volts) == pytest.approx(1e3 * QUIET["seconds"])
    assert np.array_equal(play((), {}, QUIET, step=0.025).angles, mean[:: 2 * EVERY])


def test_its_accelerations_are_those_of_the_whole_robot():
    whole = mujoco.MjModel.from_xml_string(mjcf.simple(simple_constants(), environment="suspended"))
    robot, leg = mujoco.MjData(whole), machine({}, step=1e-9)
    random = np.random.default_rng(0)
    for q, v, volts in zip(random.normal(0, 0.3, (5, 2)), random.normal(0, 0.05, (5, 2)), random.uniform(0, 225, (5, 2)), strict=True):
        robot.ctrl[:] = 112.5
        for i, joint in enumerate(JOINTS):
            robot.joint(joint).qpos, robot.joint(joint).qvel = q[i], v[i]
            robot.actuator(f"{joint}_actuator").ctrl = volts[i]
        leg.data.qpos[leg.dofs], leg.data.qvel[leg.dofs], leg.data.ctrl[:] = q, v, volts
        mujoco.mj_forward(whole, robot)
        mujoco.mj_forward(leg.model, leg.data)
        assert leg.data.qacc[leg.dofs] == pytest.approx([robot.joint(joint).qacc[0] for joint in JOINTS], rel=1e-6, abs=1e-12)


def test_voltages_are_the_first_two_channels():
    assert np.array_equal(commands(**QUIET), excitation(**QUIET).voltages[:, :2])


@pytest.mark.parametrize(
    "effect",
    [
        None,
        _effect("lugre", force=0.02),
        _effect("hertz_play", gap=0.01, stiffness=800.0, loss=20.0),
        _effect("soft_coupling", compliance=0.1, damping=0.2),
        _effect("hunt_crossley", depth=0.5, stiffness=40.0, loss=5.0),
        _effect("arctan_clip", bend=1.0),
        _effect("sliding_mass", mass=0.3, throw=1.0),
        _effect("absorber", mass=0.3, hertz=25.0, damping=0.03),
    ],
    ids=lambda effect: effect.law if effect else "no law",
)
def test_half_the_step_moves_angles_by_less_than_a_fifth_of_the_least_noise(effect):
    effects, signal = (effect,) if effect else (), LOUD | {"seconds": 1.0} if effect else LOUD
    step = LAWS[effect.law].step if effect else 0.025
    moved = play(effects, {}, signal, step=step).angles - play(effects, {}, signal, step=step / 2).angles
    assert np.sqrt(np.mean(moved**2)) < NOISE[0] * strokes()[Topic.SERVO_JOINTS] / 5


def test_a_stiff_coupling_is_no_coupling():
    plain, stiff = play((), {}, QUIET, step=0.01), play((_effect("soft_coupling", compliance=1e-4, damping=0.2),), {}, QUIET, step=0.0005)
    assert np.abs(stiff.angles - plain.angles).max() < 0.02 * np.abs(plain.angles).max()  # the rotor's own inertia, 2 %
    assert np.abs(stiff.tips[:, 0] * 1e3 / FRONT["tip_per_angle"][0] - stiff.angles[:, 0]).max() < 2e-4


def test_lost_motion_is_between_tip_and_leg():
    run = play((_effect("hertz_play", gap=0.03, stiffness=900.0, loss=20.0),), {}, QUIET, step=0.01)
    slack = run.tips[:, 0] * 1e3 / FRONT["tip_per_angle"][0] - run.angles[:, 0]
    assert 0.010 < np.abs(slack[400:]).max() < 0.020  # half the gap and a little give


def test_a_flywheel_on_both_joints_couples_their_inertia():
    leg, mass = machine({}, step=0.025, coupling=-0.2), np.zeros((2, 2))
    mujoco.mj_forward(leg.model, leg.data)
    mujoco.mj_fullM(leg.model, leg.data, mass)
    damped = np.diag(leg.model.dof_damping) * 0.025 / 2
    assert (mass + damped)[np.ix_(leg.dofs, leg.dofs)] == pytest.approx(rest_mass() + 0.2 * np.array([[1, -1], [-1, 1]]), abs=1e-9)


def test_preload_and_bias_move_the_rest_position():
    """Within what gravity, less than 2 mrad, adds."""
    still = {"kind": "trot", "seconds": 0.6, "frequency_hz": 1.0, "amplitude": 0.0}
    changes = {"preload.fl_lift": 0.05, "bias.fl_lift": 0.01}
    plain, moved = (play((), given, still, step=0.025).angles[-400:].mean(axis=0) for given in ({}, changes))
    assert moved - plain == pytest.approx([0.0, 0.05 / FRONT["stiffness"][1] + 0.01], abs=2e-3)


def test_gain_stiffness_and_sensor_factors_scale_slow_motion():
    slow = {"kind": "trot", "seconds": 1.0, "frequency_hz": 2.0, "amplitude": 50.0}
    changes = {"drive_gain.fl_swing": 1.1, "stiffness.fl_swing": 0.9, "sensor_gain.fl_swing": 1.02, "tip_gain.fl_swing": 0.97}
    plain, moved = (play((), given, slow, step=0.025) for given in ({}, changes))
    angle, tip = (np.ptp(getattr(moved, name)[:, 0]) / np.ptp(getattr(plain, name)[:, 0]) for name in ("angles", "tips"))
    assert [angle, tip] == pytest.approx([1.1 / 0.9 * 1.02, 1.1 / 0.9 * 0.97], rel=0.02)


def test_a_common_time_shift_delays_every_channel():
    plain, late = play((), {}, QUIET, step=0.025), play((), {"time_shift": 0.5}, QUIET, step=0.025)
    assert late.angles[2:] == pytest.approx(plain.angles[:-2], abs=1e-12)
    assert late.tips[2:] == pytest.approx(plain.tips[:-2], abs=1e-15)
