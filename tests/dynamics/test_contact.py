"""Feet on the ground: the force never pulls and stays in the friction cone, for any input and in whole runs; feet sink little."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from interpreter import Interpreter

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import layout
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.contact import approach, clamp

LAW = {"stiffness": value("contact.stiffness"), "damping": value("contact.damping"), "slip_speed": value("contact.slip_speed")}
WEIGHT = 1.4749911599999996 * value("robot.gravity")
speed = st.floats(-2, 2)  # mm/ms
vector = st.tuples(speed, speed, speed)
slope = st.floats(-0.5, 0.5)
friction = st.floats(0, 1.5)


def contact(height, velocity, tilt, mu):
    """Contact of a foot half a step ahead at `height` mm on ground tilted by two slopes; its normal."""
    normal = np.array([tilt[0], tilt[1], 1.0])
    normal = tuple(normal / np.linalg.norm(normal))
    return approach(height, velocity, normal, mu, SERVO_MS, **LAW), np.array(normal)


@given(st.floats(-0.5, 0.5), vector, vector, st.tuples(slope, slope), friction)
def test_ground_never_pulls_and_friction_stays_in_the_cone(height, before, after, tilt, mu):
    touch, normal = contact(height, before, tilt, mu)
    force = np.array([float(x) for x in clamp(touch, after, mu)])
    load = force @ normal
    across = force - load * normal
    assert load >= -1e-15
    assert np.linalg.norm(across) <= mu * load * (1 + 1e-9) + 1e-12
    slip = np.array(after) - (np.array(after) @ normal) * normal
    assert across @ slip <= 1e-12, "friction takes energy"


@given(st.floats(1e-6, 5), vector, vector, friction)
def test_a_foot_in_the_air_feels_nothing(height, before, after, mu):
    rise = max(before[2], 0.0)
    touch, _ = contact(height + 0.5 * SERVO_MS * abs(before[2]), (*before[:2], rise), (0.0, 0.0), mu)
    assert [float(x) for x in clamp(touch, after, mu)] == [0.0, 0.0, 0.0]


@given(st.floats(1e-5, 0.05), st.floats(0.01, 1.5))
def test_a_foot_at_rest_is_carried_by_its_spring(depth, mu):
    touch, _ = contact(-depth, (0.0, 0.0, 0.0), (0.0, 0.0), mu)
    assert float(clamp(touch, (0.0, 0.0, 0.0), mu)[2]) == pytest.approx(LAW["stiffness"] * depth, rel=1e-12)


@given(st.floats(1e-3, 0.05), st.floats(0.05, 1.5), st.floats(0, 6.28), st.floats(0.02, 2.0))
def test_a_sliding_foot_feels_coulomb_friction(depth, mu, heading, slip):
    """Twenty times the regularising speed or faster: mu times the load against the motion, within a thousandth."""
    velocity = (slip * np.cos(heading), slip * np.sin(heading), 0.0)
    touch, _ = contact(-depth, velocity, (0.0, 0.0), mu)
    x, y, load = (float(c) for c in clamp(touch, velocity, mu))
    assert [x, y] == pytest.approx([-mu * load * np.cos(heading), -mu * load * np.sin(heading)], rel=2e-3, abs=1e-3 * mu * load)


def ground_forces(robot: Interpreter) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 4) load and friction of each foot over the last step, N, and (n, 4) heights of the feet half way through it, mm."""
    force, normal = robot.leg_rows("grounded", layout.GROUNDED, "force", 3), robot.leg_rows("near", layout.NEAR, "normal", 3)
    point, height = robot.leg_rows("reach", layout.REACH, "point", 3), robot.leg_rows("near", layout.NEAR, "height", 1)[..., 0]
    load = (force * normal).sum(axis=-1)
    return load, np.linalg.norm(force - load[..., None] * normal, axis=-1), height + (point * normal).sum(axis=-1)


def trot(t: float, n: int) -> np.ndarray:
    """(n, 8) V at t ms: robots trot at 10 to 40 Hz."""
    hz = np.linspace(10, 40, n)[:, None]
    legs = np.repeat([0.0, np.pi, np.pi, 0.0], 2) + np.tile([0.5 * np.pi, 0.0], 4)
    return 112.5 + 90.0 * np.sin(2 * np.pi * hz * t / 1e3 + legs)


@pytest.mark.parametrize(("backend", "steps"), [("simple", 240), ("full", 120)])
def test_forces_in_whole_runs(backend, steps, rng):
    """Robots dropped askew and trotting on slippery to rough ground: every force of every foot at every step."""
    n = 16
    mu = np.linspace(0.1, 1.2, n)
    sim = BatchSim(backend, n, friction=mu)
    sim.set_state(velocity=rng.normal(0, 0.1, (n, 3)) - (0, 0, 0.2), angular_velocity=rng.normal(0, 0.01, (n, 3)))
    robot, touched, slid = Interpreter(sim), 0, 0
    for k in range(steps):
        robot.step(trot(k * SERVO_MS, n))
        load, across, height = ground_forces(robot)
        assert load.min() >= 0.0
        assert (across <= mu[:, None] * load * (1 + 1e-9) + 1e-12).all()
        assert (load[height > 0.02] == 0.0).all(), "a foot clear of the ground by more than half a step's motion"
        touched += np.count_nonzero(load)
        slid += np.count_nonzero(across > 0.999 * mu[:, None] * load * (load > 0))
    assert touched > 0.1 * steps * n
    assert slid > 0.02 * steps * n


@pytest.mark.parametrize("backend", ["simple", "full"])
def test_a_standing_robot_is_carried_by_its_weight(backend):
    """After 600 ms at rest the loads add up to the weight, and each foot sinks by its load over the stiffness."""
    sim = BatchSim(backend, 16)
    sim.step_voltages(np.full((16, 12000, 8), 112.5))
    robot = Interpreter(sim)
    robot.step(np.full((16, 8), 112.5))
    load, across, height = ground_forces(robot)
    assert load.sum(axis=1) == pytest.approx(WEIGHT, rel=1e-3)
    assert height == pytest.approx(-load / LAW["stiffness"], abs=1e-5)
    assert (across < value("contact.friction") * load).all()
    assert np.abs(sim.velocity).max() < 1e-3


@pytest.mark.parametrize("backend", ["simple", "full"])
@pytest.mark.parametrize(("drop", "bound"), [(0.0, 0.2), (5.0, 0.25), (50.0, 0.6)])
def test_feet_sink_little(backend, drop, bound, rng):
    """Bound of penetration, mm, falling from `drop` mm and trotting at 90 V and up to 40 Hz: 1.5 % of the leg, 5 % after 5 cm."""
    n = 16
    sim = BatchSim(backend, n)
    sim.set_state(position=sim.position + (0, 0, drop), angular_velocity=rng.normal(0, 0.002, (n, 3)))
    deepest = 0.0
    for k in range(1500):  # 300 ms, looked at every 0.2 ms
        sim.step_voltages(np.broadcast_to(trot(k * 0.2, n)[:, None], (n, 4, 8)))
        deepest = min(deepest, foot_heights(sim).min())
    assert -bound < deepest < 0.0
    assert sim.finite.all()


def foot_heights(sim: BatchSim) -> np.ndarray:
    """(n, 4) mm, by the universal joint."""
    sx, sy = np.array([1, -1, 1, -1]), np.array([1, 1, -1, -1])
    swing, lift = (sim.q.reshape(-1, 4, 2)[..., i] for i in (0, 1))
    x, y = -np.sin(swing) * 7.58 * sy, np.cos(swing) * 7.58 * sy
    y, z = np.cos(lift) * y + np.sin(lift) * 13.0, np.sin(lift) * y - np.cos(lift) * 13.0
    hip = value("leg.hip")
    w, a, b, c = sim.quaternion.T
    up = np.stack([2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)], axis=1)
    point = np.stack([x + hip[0] * sx, y + hip[1] * sy, z + hip[2]], axis=-1)
    return sim.position[:, 2:3] + np.einsum("nk,nlk->nl", up, point)
