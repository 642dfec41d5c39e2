"""The whole walking study, from a bag to files, with friction hidden in MuJoCo and a library of three names."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest

from hamr_bags.as_measured import NOISE, strokes
from hamr_bringup.direct import direct, make_engine
from hamr_bringup.graph import Run
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.effects.library import find
from hamr_gap.walking import again, looks, roles, strides
from hamr_gap.walking.bags import on_the_ground, read
from hamr_gap.walking.study import study
from hamr_gap.walking.walk import Walk, turned

FRICTION, HIDDEN = 0.51, 0.3
TROT = {"kind": "trot", "frequency_hz": 16.0, "amplitude": 40.0}


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> Walk:
    """4.6 s of a trot on slippery ground in MuJoCo, as an instrumented robot would have given it."""
    bag = tmp_path_factory.mktemp("bags") / "trot"
    run = Run(backend="simple", engine="mujoco", friction=HIDDEN, excitation=TROT | {"seconds": 4.6}, seconds=4.6, bag=str(bag))
    direct(run, engine=make_engine(run))
    assert on_the_ground(bag)
    return noisy(read([bag]), 1)


def noisy(walk: Walk, seed: int) -> Walk:
    rng = np.random.default_rng(seed)
    angles = walk.angles + rng.normal(0, NOISE * strokes()[Topic.SERVO_JOINTS], walk.angles.shape)
    position = walk.position + rng.normal(0, 0.05, walk.position.shape)
    quaternion = turned(walk.quaternion, rng.normal(0, 2e-3, walk.position.shape))
    return Walk(walk.voltages, angles, walk.step, walk.seen, position, quaternion)


def test_a_bag_gives_what_the_robot_did(walk):
    assert walk.step == pytest.approx(0.25)
    assert len(walk.voltages) == len(walk.angles) == 4.6 * 4000
    assert np.array_equal(walk.seen, np.arange(0, len(walk.angles), 16))
    assert walk.position[0, 2] == pytest.approx(12.54, abs=0.3)  # mm
    assert abs(walk.position[-1, 0]) > 30.0
    assert np.allclose(np.linalg.norm(walk.quaternion, axis=1), 1.0)


def test_a_hung_robot_is_refused(tmp_path):
    run = Run(backend="simple", environment="suspended", excitation=TROT | {"seconds": 0.6}, seconds=0.6, bag=str(tmp_path / "hung"))
    direct(run)
    assert not on_the_ground(tmp_path / "hung")
    with pytest.raises(BagError, match="hung up"):
        read([tmp_path / "hung"])


def test_friction_is_named_shown_and_written(walk, tmp_path, monkeypatch):
    names = ("ground_friction", "factor"), ("gravity_tilt", "slope"), ("cubic_stiffness", "cubic")
    monkeypatch.setattr(looks, "forms", lambda: [(name, find(name, form)) for name, form in names])
    for module, name, fewer in ((roles, "FITTED", 16), (roles, "JUDGED", 12), (looks, "SINGLES", 2), (again, "POLISHED", 1)):
        monkeypatch.setattr(module, name, fewer)  # less of everything, the same way
    monkeypatch.setattr(strides, "MOST", 12)
    found = study("simple", walk, tmp_path)
    assert found["verdict"] == "named"
    (effect,) = found["set"][0]["effects"]
    assert (effect["effect"], effect["place"]) == ("ground_friction", "all")
    assert set(effect["joints"]) == set(JOINTS)
    change = effect["parameters"]["change"]
    assert abs(FRICTION * (1 + change["value"]) - HIDDEN) < 0.03
    over = found["shown"]["over_floor"]
    assert over["after"] < 0.4 * over["retuned"]
    assert over["removed"] > 0.8 * over["retuned"]
    named = (tmp_path / "named.json").read_bytes()
    assert (tmp_path / "verdict.sha256").read_text().split()[0] == hashlib.sha256(named).hexdigest()
    assert json.loads((tmp_path / "verdict.json").read_text())["verdict"] == "named"
    sim = BatchSim("simple", 1, effects=tmp_path / "effects.yaml")
    assert sim.parameter("friction")[0] == pytest.approx(FRICTION * (1 + change["value"]))
    middle = {who: x[2] for who, x in found["shown"]["strides"]["length"].items()}
    assert abs(middle["after"] - middle["measured"]) < 0.1 * abs(middle["measured"])
    assert abs(middle["after"] - middle["measured"]) < 0.5 * abs(middle["raw"] - middle["measured"])
