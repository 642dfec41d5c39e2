"""Training lowers held-out error, from measured channels alone, to the bit, also when interrupted."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from residual_samples import noise_run, recording

from hamr_description.errors import ConfigError, ModelError
from hamr_dynamics.batch import BatchSim
from hamr_sim_residual import evaluate, fit_mlp, fit_series, model_file, surrogate
from hamr_sim_residual.dataset import SIGNS, stretches
from hamr_sim_residual.residual_plant import SHIPPED, residual_plant, torque_driven
from hamr_sim_residual.train import train

SMALL = {"architecture": "series:3", "progress": False}
SECONDS = 2.0


@pytest.fixture(scope="module")
def held_out():
    return noise_run(9, 1.0)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    out = tmp_path_factory.mktemp("model") / "residual.json"
    return out, train([recording(noise_run(0, SECONDS))], out, **SMALL)


def gain(model, truth) -> np.ndarray:
    """How many times lower than HAMR-simple's the errors of q and v are after 8 ms and 100 ms."""
    ahead = (8.0, 100.0)
    found, simple = (evaluate.errors(plant, truth, ahead) for plant in (residual_plant(model), "simple"))
    assert found.finite
    return (simple.mse / found.mse)[:, :2]


def test_two_seconds_and_a_small_law_beat_simple_by_far(trained, held_out):
    out, summary = trained
    assert gain(out, held_out).min() > 100
    assert summary["steps"] <= 4
    assert not list(out.parent.glob("*.checkpoint*"))


def test_noisy_angles_still_do(held_out, tmp_path):
    train([recording(noise_run(0, SECONDS), noise=1e-3)], tmp_path / "a.json", **SMALL)
    assert gain(tmp_path / "a.json", held_out).min() > 50


def test_unmeasured_channels_do_not_matter(trained, tmp_path):
    out, _ = trained
    run, random = noise_run(0, SECONDS), np.random.default_rng(0)
    junk = {name: random.standard_normal(run.q.shape) for name in ("torque", "acceleration", "force", "deflection_rates")}
    train([recording(run, **junk)], tmp_path / "b.json", **SMALL)
    assert (tmp_path / "b.json").read_bytes() == out.read_bytes()


def test_interrupted_training_resumes_to_the_bit(trained, tmp_path, monkeypatch):
    out, _ = trained
    data, improve, calls = [recording(noise_run(0, SECONDS))], fit_series.improve, []

    def interrupted(*args):
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        yield from improve(*args)

    monkeypatch.setattr(fit_series, "improve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        train(data, tmp_path / "c.json", **SMALL)
    monkeypatch.setattr(fit_series, "improve", improve)
    with pytest.raises(ModelError, match="other"):
        train(data, tmp_path / "c.json", **SMALL | {"architecture": "series:2"}, resume=True)
    train(data, tmp_path / "c.json", **SMALL, resume=True)
    assert (tmp_path / "c.json").read_bytes() == out.read_bytes()


@pytest.mark.parametrize("method", ["paper", "adjoint"])
def test_tanh_networks_learn_and_resume_to_the_bit(method, held_out, tmp_path, monkeypatch):
    """Few updates: enough to see that torques come out right, in the kernels too."""
    monkeypatch.setattr(surrogate, "UPDATES", 200)
    monkeypatch.setattr(surrogate, "SAMPLES", 20_000)
    monkeypatch.setattr(fit_mlp, "UPDATES", {"one-step": 300, "multi-step": 4})
    monkeypatch.setattr(fit_mlp, "SAVE_EVERY", 100)
    monkeypatch.setattr(fit_mlp, "HORIZON_MS", 1.0)
    settings = {"method": method, "architecture": "leg:20x20", "seed": 1, "progress": False}
    data = [recording(noise_run(0, 1.0))]
    train(data, tmp_path / "whole.json", **settings)
    save, saved = fit_mlp.Adam.arrays.fget, []

    def once(adam):
        if saved:
            raise KeyboardInterrupt
        saved.append(1)
        return save(adam)

    monkeypatch.setattr(fit_mlp.Adam, "arrays", property(once))
    with pytest.raises(KeyboardInterrupt):
        train(data, tmp_path / "parts.json", **settings)
    monkeypatch.setattr(fit_mlp.Adam, "arrays", property(save))
    train(data, tmp_path / "parts.json", **settings, resume=True)
    assert (tmp_path / "parts.json").read_bytes() == (tmp_path / "whole.json").read_bytes()
    still = evaluate.errors(torque_driven(_idle()), held_out, (0.25,))
    assert (still.mse / evaluate.errors(residual_plant(tmp_path / "whole.json"), held_out, (0.25,)).mse).min() > 10


def _idle():
    """A network without torque: what learning starts from."""
    law = fit_mlp.Mlp("leg", (20, 20))
    return fit_mlp.Network(law, np.zeros(len(law.rows)))


@pytest.mark.parametrize(("scope", "hidden"), [("leg", (20, 20)), ("robot", (12,))])
def test_trained_torch_network_equals_the_kernel(scope, hidden):
    """Scaling folded into the weights, rows in the kernel's order."""
    run = noise_run(0, 1.0)
    parts = stretches(recording(run))
    trainer = fit_mlp.Trainer(parts, fit_mlp.Mlp(scope, hidden), "step", seed=0)
    weights = trainer.net.initial(np.random.default_rng(3))
    at = np.array([100, 2000, 4000])
    rows = [trainer.rows(x[:, at]) for x in (trainer.data.q, trainer.data.v, trainer.data.drive)]
    torque = trainer.torque(trainer.net.split(weights), *rows).detach()
    torque = trainer.lanes(torque).numpy().reshape(2, 4, 3).transpose(2, 1, 0).reshape(3, 8)
    sim = BatchSim(torque_driven(trainer.network(weights.numpy())), 3, environment="suspended")
    sim.set_state(q=run.q[at], qd=np.moveaxis(parts[0].v[:, at] * SIGNS, 0, 1).reshape(3, 8))
    np.testing.assert_allclose(sim.observe(run.volts[at])["torque"] * SIGNS.ravel(), torque, rtol=0, atol=1e-7)


@pytest.mark.parametrize(("method", "architecture"), [("magic", ""), ("paper", "series:6"), ("adjoint", "series:0"), ("adjoint", "leg:3x")])
def test_unknown_methods_and_architectures(method, architecture, tmp_path):
    with pytest.raises(ConfigError, match="method"):
        train([], tmp_path / "x.json", method=method, architecture=architecture)


def test_training_never_imports_rclpy():
    code = "import sys; sys.modules['rclpy'] = None; import hamr_sim_residual.train, hamr_sim_residual.fit_mlp, hamr_sim_residual.evaluate"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_shipped_model_is_what_its_entry_says(held_out):
    found = evaluate.errors("residual", held_out, (8.0,))
    assert (evaluate.errors("simple", held_out, (8.0,)).mse / found.mse).min() > 1e4
    assert model_file.load(SHIPPED).training["method"] == "adjoint"
