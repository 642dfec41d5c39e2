"""Trainings are repeatable, resumable and refuse what does not belong together."""

from __future__ import annotations

import json

import numpy as np
import pytest
import torch
from conftest import SHORT, STEPS

from hamr_description.errors import ConfigError
from hamr_policy import checkpoint
from hamr_policy.backend import simulator
from hamr_policy.disturbance import DomainRandomisation, TorqueNoise, disturbance, physical
from hamr_policy.train import train


def test_equal_seeds_give_equal_files_and_others_do_not(trained, tmp_path):
    again = train("walk", "simple", tmp_path / "a", steps=STEPS, seed=3, **SHORT)
    other = train("walk", "simple", tmp_path / "b", steps=STEPS, seed=4, **SHORT)
    first = (trained / "policy.onnx").read_bytes()
    assert (tmp_path / "a" / "policy.onnx").read_bytes() == first
    assert (tmp_path / "b" / "policy.onnx").read_bytes() != first
    assert again["steps"] == STEPS and again["curve"] != other["curve"]


def test_an_interrupted_training_goes_on_to_the_bit(trained, tmp_path, monkeypatch):
    save = checkpoint.Checkpoint._save

    def save_and_stop(self):
        save(self)
        if self.model.num_timesteps:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(checkpoint.Checkpoint, "_save", save_and_stop)
        train("walk", "simple", tmp_path, steps=STEPS, seed=3, **SHORT)
    assert not (tmp_path / "policy.onnx").exists()
    result = train("walk", "simple", tmp_path, steps=STEPS, seed=3, resume=True, **SHORT)
    assert (tmp_path / "policy.onnx").read_bytes() == (trained / "policy.onnx").read_bytes()
    assert result["curve"] == json.loads((trained / "training.json").read_text())["curve"]


def test_a_checkpoint_of_another_training_is_refused(trained):
    with pytest.raises(ConfigError, match=r"another training \(seed: 3, here 5\)"):
        train("walk", "simple", trained, steps=STEPS, seed=5, resume=True, **SHORT)


def test_training_leaves_curve_checkpoint_and_tensorboard(trained):
    report = json.loads((trained / "training.json").read_text())
    assert report["settings"]["seed"] == 3 and report["curve"][-1][0] == STEPS
    assert list((trained / "tensorboard").glob("events*"))
    torch.load(trained / "checkpoint.pt", weights_only=True)  # holds nothing that could run


def test_ppo_learns_to_turn(tmp_path):
    """40 000 steps are too few for a gait, and enough to beat chance by far."""
    fast = {"robots": 64, "rollout": 16, "batch": 128, "epochs": 6, "learning_rate": 2e-3, "gamma": 0.8, "log_std": -0.5}
    curve = np.array(train("turn", "simple", tmp_path, steps=40_000, seed=0, **fast)["curve"])
    start, end = curve[:4, 1].mean(), curve[-4:, 1].mean()
    assert abs(start) < 25 and end > 60


def test_randomised_robots_differ_within_the_paper_s_bounds():
    sim = simulator("simple", 64, dtype=np.float64)
    before = {name: sim.parameter(name) for name in DomainRandomisation.NAMES}
    randomise = DomainRandomisation(sim)
    mask = np.arange(64) < 60
    randomise.begin(mask, np.random.default_rng(0))
    factors = np.stack([sim.parameter(name) / before[name] for name in DomainRandomisation.NAMES], -1)
    assert (factors[60:] == 1).all()
    assert factors.min() >= 0.7 - 1e-12 and factors.max() <= 1.3 + 1e-12
    assert 0.1 < factors[:60].std() < 0.2 and abs(factors[:60].mean() - 1) < 0.03
    assert physical(np.stack([sim.parameter(f"inertia.{i}") for i in range(6)], -1)).all()
    again = {name: sim.parameter(name) for name in DomainRandomisation.NAMES}
    randomise.begin(~mask, np.random.default_rng(1))
    assert all((sim.parameter(name)[:60] == again[name][:60]).all() for name in again)


def test_tensors_of_no_body_are_told_apart():
    tensors = [[1, 1, 1, 0, 0, 0], [1, 1, 2.1, 0, 0, 0], [1, 1, 1, 1.1, 0, 0]]
    assert physical(np.array(tensors, float)).tolist() == [True, False, False]


def test_torque_noise_is_a_hundredth_of_a_newton_millimetre():
    """Measured on the robot: the mean torque shift of the leg law at rest for the noisy targets, through the volts that it asks for."""
    sim = simulator("simple", 512, dtype=np.float64)
    targets = TorqueNoise(sim).targets(np.zeros((512, 8)), np.random.default_rng(0))
    volts = sim.step_targets(targets, steps=1, record=True)["volts"][:, 0]
    torques = sim.observe(volts)["torque"]
    assert torques.std(axis=0) == pytest.approx(np.full(8, 0.01), rel=0.1)


def test_unknown_disturbances_and_backends_without_their_parameters_are_named():
    with pytest.raises(ConfigError, match="'wind'"):
        disturbance("wind", simulator("simple", 1))
    with pytest.raises(ConfigError, match=r"inertia\.0"):
        disturbance("randomised", simulator("full", 1))
