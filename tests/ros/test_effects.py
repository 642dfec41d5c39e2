"""A graph with effects: processes give what the run without ROS gives, /run_info names the effects, and a bad file ends it at once."""

from __future__ import annotations

import pytest
from harness import contents

from hamr_bags.bag import open_bag
from hamr_bags.cdr import text
from hamr_bags.run_info import RunInfo
from hamr_bringup.direct import direct
from hamr_bringup.graph import Run
from hamr_bringup.supervisor import NodeFailed, up
from hamr_description.errors import ConfigError
from hamr_description.names import Topic
from hamr_dynamics.effects.effects_file import Change, EffectsFile, PlacedEffect, write

FILE = EffectsFile(
    (
        PlacedEffect("coulomb_friction", "presliding", ("fl",), {"level": 8e-6, "distance": 0.005}),
        PlacedEffect("sensor_latency", "pade", ("rear",), {"delay": 2e-4}),
        PlacedEffect("piezo_hysteresis", "bouc_wen", ("left",), {"size": 0.2, "width": 20.0}),
    ),
    (Change("stiffness", ("left",), 1e-5),),
)
NOISE = {"kind": "noise", "seconds": 0.2, "seed": 5, "band_hz": 100.0}


def run(**more) -> Run:
    """A suspended run: the kernel that the tests of the dynamics compile."""
    return Run(backend="simple", environment="suspended", excitation=NOISE, seconds=0.2, real_time_factor=0.0, **more)


def test_processes_and_direct_agree_with_effects(graph, tmp_path):
    path = tmp_path / "effects.yaml"
    write(FILE, path)
    up(run(bag=str(tmp_path / "up"), effects=str(path)))
    direct(run(bag=str(tmp_path / "direct"), effects=str(path)))
    direct(run(bag=str(tmp_path / "plain")))
    found, expected, plain = (contents(tmp_path / name) for name in ("up", "direct", "plain"))
    assert found == expected
    assert len(found[Topic.SERVO_JOINTS]) == 50
    assert found[Topic.SERVO_JOINTS] != plain[Topic.SERVO_JOINTS]
    with open_bag(tmp_path / "up") as bag:
        info = next(RunInfo.from_json(text(m.raw)) for m in bag.messages() if m.topic == Topic.RUN_INFO)
    assert [entry.get("effect", entry.get("change")) for entry in info.effects] == [
        "coulomb_friction", "sensor_latency", "piezo_hysteresis", "stiffness",
    ]  # fmt: skip
    assert info.effects_hash == FILE.hash


def test_a_bad_file_ends_the_run_with_its_sentence(graph, tmp_path):
    path = tmp_path / "effects.yaml"
    path.write_text("effects: [{effect: kulomb, parameters: {}}]")
    with pytest.raises(NodeFailed, match=r"simulator: Effects file '.*effects.yaml': effect 1: There is no effect 'kulomb'"):
        up(run(effects=str(path)))


def test_mujoco_refuses_effects(tmp_path):
    path = tmp_path / "effects.yaml"
    write(FILE, path)
    for backend in ("full", "simple"):
        with pytest.raises(ConfigError, match="effects need the kernel engine"):
            direct(Run(backend=backend, engine="mujoco", effects=str(path), seconds=0.1))
