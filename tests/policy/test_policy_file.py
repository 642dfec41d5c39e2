"""Exported policies do what the network does, at once, and files that do not fit are refused in one sentence."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import onnx
import pytest
import torch
from onnx import helper
from stable_baselines3.common.policies import ActorCriticPolicy

from hamr_description.errors import ModelError
from hamr_description.names import JOINTS
from hamr_policy.export import Origin, export
from hamr_policy.network import Normalise
from hamr_policy.observation import VIEWS, components, observe, place
from hamr_policy.policy_file import KEY, interface
from hamr_policy.runtime import Policy, PolicyRuntime
from hamr_policy.spaces import action_space, observation_space
from hamr_policy.state import State
from hamr_policy.task import TARGET_LIMIT


def network(view: str, activation=torch.nn.ELU) -> ActorCriticPolicy:
    """An untrained policy whose actions reach the clipping."""
    torch.manual_seed(1)
    policy = ActorCriticPolicy(
        observation_space(view), action_space(), lambda _: 0.0, net_arch=[64, 64], activation_fn=activation,
        features_extractor_class=Normalise, features_extractor_kwargs={"view": view},
    )  # fmt: skip
    with torch.no_grad():
        policy.action_net.weight.mul_(200)
    return policy


def write(path, view: str = "heading", *, activation=torch.nn.ELU, **changes):
    """A policy file of an untrained network; changes: of its Origin."""
    origin = {"task": "walk", "view": view, "backend": "full", "residual": "", "disturbance": "", "seed": 1, "steps": 0}
    return export(network(view, activation), Origin(**origin | changes), path)


def observations(view: str, n: int = 256) -> np.ndarray:
    rows = components(view)
    spread = np.random.default_rng(0).normal(size=(n, len(rows)))
    return (spread * [row["scale"] for row in rows] + [row["centre"] for row in rows]).astype(np.float32)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("activation", (torch.nn.ELU, torch.nn.Tanh))
def test_the_file_computes_what_the_network_does(view, activation, tmp_path):
    file, seen = Policy(write(tmp_path / "p.onnx", view, activation=activation)), observations(view)
    actions, _ = network(view, activation).predict(seen, deterministic=True)  # stable-baselines3 clips them
    assert 0.05 < (np.abs(actions) == 1).mean() < 0.95
    np.testing.assert_allclose(file.targets(seen), actions * TARGET_LIMIT, atol=1e-5)


def test_the_file_says_what_it_is(trained):
    about = Policy(trained / "policy.onnx").about
    assert (about["task"], about["backend"], about["seed"]) == ("walk", "simple", 3)
    assert about["directions"] == {"+1": "forward", "-1": "backward"}
    assert about["normalisation"]["scale"] == [row["scale"] for row in components(about["view"])]
    assert about["action"]["joints"] == list(JOINTS) and about["target_hz"] == 250
    assert [row["unit"] for row in about["observation"] if row["name"].startswith("hip_rate")] == ["rad/s"] * 8
    assert about["parameters_hash"] and about["versions"]["torch"]


def test_one_robot_is_driven_from_topics(tmp_path):
    """The runtime equals the batch of one, remembers where the primitive began, and forgets it on reset."""
    path, rng = write(tmp_path / "p.onnx"), np.random.default_rng(2)
    runtime, policy = PolicyRuntime(path), Policy(path)
    start = None
    for step in range(6):
        if step == 3:
            runtime.reset()
            start = None
        turn = rng.normal(size=4)
        base = np.concatenate([rng.normal(size=3), turn / np.linalg.norm(turn), rng.normal(size=6)])
        sample = rng.normal(size=(7, 8))
        state = State.of_sample(sample, base)
        start = place(state) if start is None else start
        expected = policy.targets(observe("heading", state, np.array([-1.0]), start))[0]
        targets = runtime.act(sample, base, -1)
        assert targets.shape == (8,) and targets.dtype == np.float64 and np.array_equal(targets, expected)


def test_no_torch_is_needed_to_drive(tmp_path):
    code = f"""
import sys
import numpy as np
from hamr_policy.runtime import PolicyRuntime
PolicyRuntime({str(write(tmp_path / "p.onnx"))!r}).act(np.zeros((7, 8)), np.array([0, 0, 0.0127, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0.0]), 1)
assert not {{"torch", "gymnasium", "stable_baselines3", "onnx"}} & set(sys.modules), sorted(sys.modules)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda about: about["action"]["joints"].reverse(), r"another robot \(action: joints: 0: rr_lift, here fl_swing\)"),
        (lambda about: about.update(target_hz=500), r"target_hz: 500, here 250"),
        (lambda about: about["observation"][3].update(unit="mm/s"), r"observation: 3: unit: mm/s, here m/s"),
        (lambda about: about["observation"].pop(), r"observation: 26 values, here 27"),
        (lambda about: about.update(view="everywhere"), r"no view 'everywhere'"),
        (lambda about: about.update(task="swim"), r"no task that this robot knows \(walk, turn\)"),
        (lambda about: about.update(format="hamr policy 0"), r"format: hamr policy 0"),
        (lambda about: about["action"].update(limit=1.0), r"limit: 1.0"),
    ],
)
def test_files_for_other_robots_are_refused(change, said, tmp_path):
    path = write(tmp_path / "p.onnx")
    model = onnx.load(path)
    about = json.loads(model.metadata_props[0].value)
    change(about)
    model.metadata_props[0].value = json.dumps(about)
    onnx.save(model, path)
    with pytest.raises(ModelError, match=said) as refusal:
        PolicyRuntime(path)
    assert "\n" not in str(refusal.value)


def test_what_is_no_policy_is_refused(tmp_path):
    with pytest.raises(ModelError, match="no policy file"):
        PolicyRuntime(tmp_path / "missing.onnx")
    noise = tmp_path / "noise.onnx"
    noise.write_bytes(b"\x00\x01 not a model")
    with pytest.raises(ModelError, match="not a readable ONNX file"):
        PolicyRuntime(noise)
    foreign = write(tmp_path / "foreign.onnx")
    model = onnx.load(foreign)
    del model.metadata_props[:]
    onnx.save(model, foreign)
    with pytest.raises(ModelError, match="does not say what it was made for"):
        PolicyRuntime(foreign)


def test_a_network_of_another_size_than_described_is_refused(tmp_path):
    path = write(tmp_path / "p.onnx", "nowhere")
    model = onnx.load(path)
    about = json.loads(model.metadata_props[0].value)
    helper.set_model_props(model, {KEY: json.dumps({**about, **interface("walk", "heading"), "view": "heading"})})
    onnx.save(model, path)
    with pytest.raises(ModelError, match="input and output"):
        PolicyRuntime(path)
