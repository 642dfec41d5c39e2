"""The observation of a known state, value by value, from a simulator and from topics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.engine import BASE_SIZE, ROWS
from hamr_policy.observation import VIEWS, components, observe, place, relative
from hamr_policy.state import State, into_base

ROLL, PITCH, YAW = 0.1, -0.2, 0.7
POSITION, VELOCITY, TURN = (1.5, -2.5, 13.0), (0.1, 0.2, 0.3), (0.001, -0.002, 0.003)  # mm, mm/ms in the world, rad/ms in the body
ANGLES, RATES = np.arange(8) / 100, np.arange(8) / -1000  # rad, rad/ms


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


@pytest.fixture
def turned() -> Rotation:
    return Rotation.from_euler("ZYX", [YAW, PITCH, ROLL])


@pytest.fixture
def seen(turned) -> State:
    sim = BatchSim("simple", 2)
    x, y, z, w = turned.as_quat()
    sim.set_state(q=ANGLES, qd=RATES, position=POSITION, quaternion=(w, x, y, z), velocity=VELOCITY, angular_velocity=TURN)
    return State.of_batch(sim)


def test_values_stand_in_order_and_si(seen, turned):
    start = np.array([[1e-3, 0.0, 0.2]] * 2)
    values = dict(zip([row["name"] for row in components("place")], observe("place", seen, np.array([1.0, -1.0]), start)[1], strict=True))
    moved = np.array([0.5e-3, -2.5e-3])
    c, s = np.cos(0.2), np.sin(0.2)
    velocity = turned.inv().apply(VELOCITY)
    expected = {
        "height.z": 0.013, "tilt.roll": ROLL, "tilt.pitch": PITCH, "heading.yaw": YAW - 0.2, "command.direction": -1.0,
        "place.x": c * moved[0] + s * moved[1], "place.y": c * moved[1] - s * moved[0],
        **{f"velocity.{axis}": v for axis, v in zip("xyz", velocity, strict=True)},
        **{f"angular_velocity.{axis}": 1e3 * w for axis, w in zip("xyz", TURN, strict=True)},
        **{f"hip_angle.{joint}": q for joint, q in zip(JOINTS, ANGLES, strict=True)},
        **{f"hip_rate.{joint}": 1e3 * v for joint, v in zip(JOINTS, RATES, strict=True)},
    }  # fmt: skip
    assert values == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_units_are_si():
    assert {row["unit"] for row in components("place")} == {"m", "rad", "m/s", "rad/s", "1"}


@pytest.mark.parametrize("view", VIEWS)
def test_topics_give_what_the_simulator_gives(view, seen, turned):
    sample = np.full((len(ROWS), 8), np.nan)
    sample[0], sample[1] = ANGLES, 1e3 * RATES
    base = np.concatenate([np.array(POSITION) / 1e3, turned.as_quat(), turned.inv().apply(VELOCITY), 1e3 * np.array(TURN)])
    assert base.size == BASE_SIZE
    topics = State.of_sample(sample, base)
    start = np.array([[0.0, 0.0, 0.1]])
    ours = observe(view, topics, np.ones(1), start)
    assert ours.shape == (1, len(components(view)))
    np.testing.assert_allclose(ours[0], observe(view, seen, np.ones(2), np.repeat(start, 2, 0))[0], rtol=1e-6, atol=1e-7)


def test_relative_places_do_not_depend_on_where_a_primitive_starts(rng):
    start, step = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    here = start + np.column_stack([c * step[:, 0] - s * step[:, 1], s * step[:, 0] + c * step[:, 1], step[:, 2]])
    np.testing.assert_allclose(relative(here + (0, 0, 2 * np.pi), start), step, atol=1e-12)


def test_views_without_place_are_blind_to_it(seen):
    command = np.ones(2)
    elsewhere = place(seen) + (0.3, -0.4, 0.0)
    assert (observe("heading", seen, command, elsewhere) == observe("heading", seen, command, place(seen))).all()
    assert (observe("nowhere", seen, command, elsewhere + (0, 0, 1)) == observe("nowhere", seen, command, place(seen))).all()


def test_world_vectors_in_the_base(rng):
    turns, vectors = Rotation.random(20, random_state=1), rng.normal(size=(20, 3))
    np.testing.assert_allclose(into_base(turns.as_quat(), vectors), turns.inv().apply(vectors), atol=1e-12)


def test_an_unknown_view_is_named():
    with pytest.raises(ConfigError, match=r"'everywhere'.*nowhere, heading, place"):
        components("everywhere")
