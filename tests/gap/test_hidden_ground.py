"""Hidden robots that walk: each effect does what physics says, nothing hidden is plain MuJoCo, and bags do not tell."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from hamr_bags.decode import decode_all
from hamr_bags.excitation import excitation
from hamr_bags.topics import ODOMETRY, TRAJECTORY
from hamr_description.errors import ConfigError, ModelError
from hamr_description.names import ACTUATORS, JOINTS, torque_sign
from hamr_description.numbers import value
from hamr_sim_residual.mujoco_simple import simple_engine
from hidden_gap.case import Effect
from hidden_gap.ground import GROUPS, GroundCase, draw, turn, write
from hidden_gap.ground.bag import seen
from hidden_gap.ground.laws import GROUND_LAWS, OF_LEGS, Scene, families, laws_of, scene
from hidden_gap.ground.machine import Walker
from hidden_gap.ground.retune import left
from hidden_gap.ground.starts import STARTS, moved, settled
from hidden_gap.ground.strength import SEGMENT, Floors, Pieces, shown, walked
from hidden_gap.laws.law import LAWS

TROT = {"kind": "trot", "seconds": 1.0, "frequency_hz": 10.0, "amplitude": 60.0}
CASE = GroundCase("secret-name", "ground", 987654321, (), {}, 1.0, TROT, 3e-3)
FLOORS = Floors.of(3e-3, 5e-5, 2e-3)
NEUTRAL, GRAVITY = value("actuator.neutral_voltage"), value("robot.gravity")
LOAD = {"mass": 1.5, "forward": 0.0, "left": 0.0, "up": 3.0}
HIGH = 60.0  # mm above the ground, out of its reach


def _effect(name: str, **parameters: float) -> Effect:
    law = GROUND_LAWS.get(name) or LAWS[name]
    return Effect(law.family, JOINTS if name in LAWS else (), name, parameters)


def _still(milliseconds: float) -> np.ndarray:
    return np.full((round(milliseconds * 20), 8), NEUTRAL)


def _moved(walker: Walker, volts: np.ndarray, *, height: float = 0.0, speed: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Coordinates (n, 15) at 4 kHz from the stand lifted by `height` mm with a horizontal speed, mm/ms."""
    qpos, qvel = walker.data.qpos.copy(), walker.data.qvel.copy()
    qpos[2] += height
    qvel[:2] = speed
    walker.set(qpos, qvel)
    return walker.run(volts).qpos


def _flown(*effects: Effect, ms: float = 20.0) -> np.ndarray:
    """(3,) mm by which effects move the base in the air."""
    with_them, without = (_moved(Walker(made, {}), _still(ms), height=HIGH) for made in (scene(effects), Scene()))
    return (with_them - without)[-1, :3]


def test_nothing_hidden_is_the_plain_simulator_bit_for_bit():
    engine, states, volts = simple_engine(), [], excitation(**TROT | {"seconds": 0.3}).voltages
    for k, row in enumerate(volts):
        if k % SEGMENT == 0:
            states.append((engine.data.qpos.copy(), engine.data.qvel.copy()))
        engine.substep(row)
    assert engine.counters()["stops_hit"] == 0.0
    run = Walker(Scene(), {}, step=0.05).run(volts, range(0, len(volts), SEGMENT))
    assert np.abs(run.qpos[-1, 7:]).max() > 0.02
    assert all(np.array_equal(*pair) for pair in zip(run.mark_qpos, [qpos for qpos, _ in states], strict=True))
    assert all(np.array_equal(*pair) for pair in zip(run.mark_qvel, [qvel for _, qvel in states], strict=True))


@pytest.mark.parametrize("joint", JOINTS)
def test_each_drive_moves_the_angle_of_its_own_joint_most(joint):
    volts = _still(10.0)
    volts[:, JOINTS.index(joint)] += 40.0
    way = np.abs(_moved(Walker(Scene(), {}), volts, height=HIGH)[-1, 7:])
    assert JOINTS[int(np.argmax(way))] == joint


def test_nothing_shows_where_nothing_is_hidden():
    changes = {f"stiffness.{joint}": 1.1 for joint in JOINTS}
    channels = shown(walked((), changes, CASE.volts()), changes, CASE.volts(), FLOORS)
    assert max(channels.values()) < 1e-4
    assert max(shown(walked((), changes, CASE.volts()), {}, CASE.volts(), FLOORS).values()) > 0.1


CHANGED = {f"{kind}.{joint}": 1.2 for kind in ("stiffness", "damping", "drive_gain") for joint in JOINTS[::2]}


@pytest.mark.parametrize(
    ("effects", "changes", "late", "share"),
    [
        ((), CHANGED, 0, (0.0, 0.25)), ((), {}, 12, (0.0, 0.25)), ((("slope", {"slope": 0.2, "downhill": 0.5}),), CHANGED, 0, (0.05, 0.5)),
        ((("other_surface", {"change": 0.7, "side": -1.0}),), {}, 0, (0.5, 1.0)),
    ],
)  # fmt: skip
def test_a_re_tune_takes_up_parameters_lateness_and_most_of_a_slope_but_no_other_surface(effects, changes, late, share, monkeypatch):
    """A slope is preloads, zeros, and starts within what sensors tell."""
    monkeypatch.setattr("hidden_gap.ground.retune.PIECES", 5)
    volts = CASE.volts()
    heard = np.concatenate([np.repeat(volts[:1], late, axis=0), volts[: len(volts) - late]])
    run = walked(tuple(_effect(name, **parameters) for name, parameters in effects), changes, heard)
    given, after = max(shown(run, {}, volts, FLOORS).values()), max(left(run, {}, volts, FLOORS).values())
    alone = max(shown(run, changes, volts, FLOORS).values()) if effects else given
    assert given > 2.0
    assert share[0] * alone < after < share[1] * alone


def test_where_a_piece_begins_is_known_no_better_than_its_sensors():
    """A robot that began within their errors is settled onto the one that did not."""
    pieces = Pieces.of(walked((), {}, CASE.volts()), CASE.volts(), FLOORS, 3)
    robot, away = Walker(Scene(), {}), np.random.default_rng(0).normal(0.0, 0.3, (3, STARTS))
    other, none = moved(pieces, away), np.zeros((3, STARTS))
    np.testing.assert_allclose(np.linalg.norm(other.qpos[:, 3:7], axis=1), 1.0, rtol=1e-9)
    before, nothing = other.missed(robot), np.zeros_like(pieces.missed(robot))
    back = settled(other, robot, nothing, none)
    after = moved(other, back).missed(robot)
    assert np.sqrt(np.mean(after**2)) < 0.35 * np.sqrt(np.mean(before**2))
    np.testing.assert_allclose(settled(pieces, robot, nothing, none), none, atol=1e-3)  # which begins where the run was


def test_half_the_step_shows_less_than_half_a_floor_on_average():
    fine = walked((), {}, CASE.volts(), step=0.0125)
    assert np.sqrt(np.mean(np.square(list(shown(fine, {}, CASE.volts(), FLOORS).values())))) < 0.5


def test_a_payload_is_harder_to_move():
    """Lifted in the air, where the legs, on their springs, follow in part."""
    pull, load = _effect("hanging_wire", force=2e-3, direction=0.0, rise=np.pi / 2, forward=0.0), _effect("payload", **LOAD)
    masses = Walker(Scene(), {}).model.body_mass
    light, heavy = _flown(pull)[2], (_flown(pull, load) - _flown(load))[2]
    least, most = masses.max() / (masses.max() + LOAD["mass"]), masses.sum() / (masses.sum() + LOAD["mass"])
    assert least < heavy / light < 1.1 * most
    assert masses.max() < 0.5 * 2e-3 * 20.0**2 / light < 1.1 * masses.sum()


@pytest.mark.parametrize(
    ("name", "parameters", "way"),
    [
        ("other_surface", {"change": 0.5, "side": -1.0}, 1.0),
        ("other_surface", {"change": 0.5, "side": 1.0}, -1.0),
        ("slippery_when_fast", {"fall": 0.8, "slip": 0.02}, 1.0),
    ],
)
def test_friction_shortens_slip(name, parameters, way):
    plain, other = (
        _moved(Walker(made, {}), _still(50.0), speed=(0.0, 0.15))[-1, 1] for made in (Scene(), scene((_effect(name, **parameters),)))
    )
    assert way * (other - plain) > 0.2


def test_a_slope_pulls_downhill():
    fallen = _flown(_effect("slope", slope=0.1, downhill=0.5))
    assert fallen[:2] == pytest.approx(0.5 * GRAVITY * 400.0 * np.sin(0.1) * np.array([np.cos(0.5), np.sin(0.5)]), rel=0.05)
    assert fallen[2] == pytest.approx(0.5 * GRAVITY * 400.0 * (1 - np.cos(0.1)), rel=0.05)


def test_a_coil_pulls_home_and_no_harder_than_its_force():
    walker = Walker(scene((_effect("coiled_wire", force=2e-3, reach=10.0, forward=0.0),)), {})
    away, far = (_moved_from(walker, x) for x in (5.0, 500.0))
    assert away[0] < 0.0
    assert far[0] == pytest.approx(away[0] * (500 / 510) / (5 / 15), rel=0.1)


def _moved_from(walker: Walker, x: float) -> np.ndarray:
    qpos = walker.model.key("stand").qpos.copy()
    qpos[:3] += x, 0.0, 0.0
    walker.set(qpos, np.zeros(walker.model.nv))
    walker.data.xfrc_applied[:] = 0.0
    plain = Walker(replace(walker.scene, coil=0.0), {})
    plain.model.opt.gravity[:] = walker.model.opt.gravity[:] = 0.0
    plain.set(qpos, np.zeros(walker.model.nv))
    return (walker.run(_still(5.0)).qpos - plain.run(_still(5.0)).qpos)[-1, :3]


@pytest.mark.parametrize("name", ["soft_mat", "foam"])
def test_feet_sink_into_soft_ground_by_their_load_over_its_stiffness(name):
    softness = 30.0
    soft, hard = (
        _moved(Walker(made, {}), _still(400.0))[-1, 2] for made in (scene((_effect(name, softness=softness, loss=2.0),)), Scene())
    )
    load = Walker(Scene(), {}).model.body_mass.sum() * GRAVITY / 4
    assert hard - soft == pytest.approx(load / value("contact.stiffness") * (softness - 1.0), rel=0.1)  # the ends carry unequal loads


@pytest.mark.parametrize(
    ("name", "parameters", "ms"),
    [
        ("lugre", {"force": 0.02, "presliding": 1e-3, "damping": 0.3}, 4.0),
        ("elasto_plastic", {"force": 0.02, "presliding": 1e-3, "yielding": 0.5}, 4.0),
        ("cube", {"stiffness": 5.0, "softening": 0.0}, 4.0),
        ("sinh_spring", {"stiffness": 2.0, "width": 0.1}, 4.0),
        ("exact_lag", {"tau": 2.0}, 2.0),
        ("cable_and_amplifier", {"tau": 2.0, "second": 0.1}, 2.0),
        ("ring_buffer", {"tau": 1.0}, 2.0),
        ("hard_clip", {"depth": 0.6, "side": 0.0}, 4.0),
        ("arctan_clip", {"bend": 3.0}, 4.0),
    ],
)
def test_hips_answer_a_step_of_the_drives_later_or_less(name, parameters, ms):
    assert LAWS[name].family in OF_LEGS
    signs = np.array([torque_sign(joint) for joint in JOINTS])
    volts = _still(ms) + 80.0 * signs
    plain, other = (
        _moved(Walker(made, {}), volts, height=HIGH)[:, 7:].max(axis=0) for made in (Scene(), scene((_effect(name, **parameters),)))
    )
    assert (plain > 0.05).all()
    assert ((other > 0.0) & (other < 0.97 * plain)).all()


@pytest.mark.parametrize(("name", "parameters"), [("payload", LOAD), ("cube", {"stiffness": 5.0, "softening": 0.0})])
def test_what_shows_is_the_same_on_another_simulator(name, parameters):
    """The engine of hamr_sim_residual, from the same states, at its own step."""
    volts, engine, squares = CASE.volts(), simple_engine(), []
    run = walked((_effect(name, **parameters),), {}, volts)
    given = shown(run, {}, volts, FLOORS)
    channel = max(JOINTS, key=given.get)
    assert given[channel] > 1.0
    column, place = 7 + JOINTS.index(channel), engine.model.joint(channel).qposadr[0]
    for k, (qpos, qvel) in enumerate(zip(run.mark_qpos, run.mark_qvel, strict=True)):
        engine.data.qpos[:], engine.data.qvel[:] = qpos, qvel
        for j, row in enumerate(volts[k * SEGMENT : (k + 1) * SEGMENT]):
            if j % 5 == 0:
                squares.append((engine.data.qpos[place] - run.qpos[(k * SEGMENT + j) // 5, column]) ** 2)
            engine.substep(row)
    assert np.sqrt(np.mean(squares)) / FLOORS.angle == pytest.approx(given[channel], rel=0.15)


def test_a_case_has_its_strength_once_the_robot_is_tuned_again(monkeypatch):
    monkeypatch.setattr("hidden_gap.ground.retune.PIECES", 5)
    case = draw("ground", 34, seconds=1.0)
    assert [effect.family for effect in case.effects] == [turn("ground", 34)]
    assert case.reached == max(case.channels.values()) == pytest.approx(case.strength, rel=0.101)
    given = shown(case.run(), case.changes, case.volts(), case.floors)
    assert max(given.values()) > case.reached


def test_equal_seeds_give_equal_cases_and_turns_are_taken():
    assert {turn("ground", seed) for seed in range(len(families()))} == set(families())
    assert set(families()) >= {"ground_friction", "ground_compliance", "added_mass", "gravity_tilt", "tether_force", *OF_LEGS}
    assert all(laws_of(family) for family in families())
    nothing, changes = GROUPS["ground_null"].index("nothing"), GROUPS["ground_null"].index("changes")
    case = draw("ground_null", changes, seconds=1.0)
    assert case == draw("ground_null", changes, seconds=1.0) != draw("ground_null", changes + 2, seconds=1.0)
    assert case.changes
    assert not case.effects
    assert not draw("ground_null", nothing, seconds=1.0).changes
    with pytest.raises(ConfigError, match="no group"):
        draw("single", 0)


def test_a_strength_beyond_all_bounds_is_refused(monkeypatch):
    monkeypatch.setattr(import_module("hidden_gap.ground.draw"), "ATTEMPTS", 1)
    with pytest.raises(ConfigError, match="ask for less"):
        draw("ground", families().index("gravity_tilt"), strength=1e5, seconds=1.0)


def test_a_robot_on_its_back_is_no_case():
    with pytest.raises(ModelError, match="falls over"):
        walked((_effect("hanging_wire", force=0.05, direction=1.5, rise=1.2, forward=-15.0),), {}, excitation(**TROT).voltages)


def test_the_bag_holds_what_was_measured_and_no_answer(tmp_path):
    case = replace(CASE, effects=(_effect("payload", mass=1.234567, forward=1.0, left=0.0, up=3.0),), changes={"bias.fl_lift": 0.01718})
    answer = write(case, tmp_path / "bag")
    assert json.loads(json.dumps(answer))["effects"][0]["law"] == "payload"
    found, run = seen(case, case.run()), case.run()
    with Reader(tmp_path / "bag") as reader:
        raws = {c.topic: [raw for _, _, raw in reader.messages([c])] for c in reader.connections}
    assert set(raws) == {"/run_info", "/servo/joints", "/servo/voltages", "/odom"}
    for topic, field, names, expected in (("joints", "positions", JOINTS, found.angles), ("voltages", "effort", ACTUATORS, found.volts)):
        ((_, numbers),) = decode_all(raws[f"/servo/{topic}"], TRAJECTORY, names)
        assert np.array_equal(numbers[field].reshape(-1, 8), expected)
    ((_, odometry),) = decode_all(raws["/odom"], ODOMETRY)
    assert np.array_equal(odometry["position"], found.position)
    assert np.array_equal(np.roll(odometry["orientation"], 1, axis=1), found.orientation)
    assert np.array_equal(odometry["angular"], found.angular)
    assert (found.position - 1e-3 * run.qpos[::16, :3]).std(axis=0) == pytest.approx([case.position_noise] * 3, rel=0.2)
    spread = (found.angles - run.qpos[:, 7:]).std(axis=0)
    assert spread == pytest.approx([case.floors.angle] * 8, rel=0.05)
    assert (found.angles - run.qpos[:, 7:]).mean(axis=0) == pytest.approx([0, 0.01718, 0, 0, 0, 0, 0, 0], abs=5 * case.floors.angle / 60)
    everything = b"".join(path.read_bytes() for path in (tmp_path / "bag").iterdir()) + b"".join(
        raw for group in raws.values() for raw in group
    )
    words = [case.name, str(case.seed), "hidden", "mujoco", *LAWS, *GROUND_LAWS, *families(), "1.234567", "0.01718"]
    assert [word for word in words if word.encode() in everything] == []


def test_motion_capture_sees_how_the_base_moves():
    """Without noise its rates are MuJoCo's own, in base_link."""
    case = replace(CASE, position_noise=0.0, orientation_noise=0.0, excitation=TROT | {"frequency_hz": 3.0})
    run = case.run()
    found, states = seen(case, run), slice(2, None)
    every = SEGMENT // 80
    rates = run.mark_qvel[states]
    assert np.linalg.norm(found.orientation, axis=1) == pytest.approx(np.ones(len(found.orientation)))
    turning = found.angular[::every][states][: len(rates)]
    assert np.sqrt(np.mean((turning - 1e3 * rates[:, 3:6]) ** 2)) < 0.3 * np.sqrt(np.mean((1e3 * rates[:, 3:6]) ** 2))
    speed = np.linalg.norm(found.linear[::every][states][: len(rates)], axis=1)
    assert np.corrcoef(speed, np.linalg.norm(rates[:, :3], axis=1))[0, 1] > 0.9
