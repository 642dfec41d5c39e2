"""PPO by stable-baselines3 on simulated robots: seeded, resumable to the bit, exported to ONNX."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure

from hamr_dynamics.effects.effects_file import EffectsFile
from hamr_dynamics.effects.effects_file import load as load_effects

from .backend import residual_digest, simulator
from .checkpoint import Checkpoint
from .disturbance import disturbance as find_disturbance
from .episodes import Episodes
from .export import Origin, export
from .network import Normalise
from .observation import DEFAULT_VIEW
from .progress import Progress
from .task import task_named
from .vector import HamrVecEnv

LAST = 10  # updates whose episodes make up the reward that is reported


@dataclass(frozen=True, slots=True)
class Settings:
    """What a trained policy depends on, besides the code and the versions of the libraries.

    Attributes:
        task, backend: see `task.TASKS` and `backend.simulator`; residual: digest of the residual model, or empty.
        effects: hash of what was added to the model, or empty.
        disturbance: key of `disturbance.DISTURBANCES`, or empty. view: key of `observation.VIEWS`.
        going: share of episodes that go on from the last one's end, see `vector.HamrVecEnv`.
        log_std: of the actions, at the start. learning_rate: at the start, falls to 0 in a straight line.
        robots, rollout (steps of each between updates), batch, epochs, gamma, gae_lambda, hidden: of PPO, as usual.
    """

    task: str
    backend: str
    residual: str = ""
    disturbance: str = ""
    view: str = DEFAULT_VIEW
    steps: int = 1_000_000
    seed: int = 0
    robots: int = 256
    rollout: int = 8
    batch: int = 512
    epochs: int = 5
    learning_rate: float = 2e-3
    gamma: float = 0.97
    gae_lambda: float = 0.95
    log_std: float = -1.0
    going: float = 0.9
    hidden: tuple[int, ...] = (64, 64)
    effects: str = ""


def train(
    task: str, backend: str, out: str | Path, *, steps: int = 1_000_000, seed: int = 0, residual: str | Path = "",
    effects: str | Path | EffectsFile = "",
    disturbance: str = "", view: str = DEFAULT_VIEW, resume: bool = False, **more: float,
) -> dict:  # fmt: skip
    """Trains one policy on one core.

    Equal settings give equal policies to the bit on the same machine and versions, whether or not the training was interrupted and resumed.

    Args:
        task: walk or turn.
        backend, residual, effects: see `backend.simulator`.
        out: folder for policy.onnx, training.json (settings and learning curve), checkpoint.pt and tensorboard/.
        steps: of 4 ms, all robots together; rounded up to whole updates.
        disturbance: "noise" or "randomised", the paper's comparisons on HAMR-simple.
        view: what is seen of x, y and yaw.
        resume: go on from the checkpoint in `out`, where there is one.
        more: other Settings.

    Returns:
        policy (path), steps, reward (mean over the last episodes), seconds, curve [[steps, reward], ...].

    Raises:
        ConfigError: unknown names, an effects file that does not fit, or a checkpoint of other settings.
        ModelError: the residual model does not fit.
    """
    digest = residual_digest(backend, residual)
    effects = load_effects(effects)
    settings = Settings(task, backend, digest, disturbance, view, steps, seed, effects=effects.hash, **more)
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    sim = simulator(backend, settings.robots, residual=residual, effects=effects)
    episodes = Episodes(task_named(task), sim, view, disturbance=find_disturbance(disturbance, sim))
    env = HamrVecEnv(episodes, going=settings.going)
    model = ppo(settings, env)
    checkpoint = Checkpoint(out / "checkpoint.pt", asdict(settings), env)
    model.set_logger(configure(str(out / "tensorboard"), ["tensorboard"]))
    done = checkpoint.load(model) if resume else 0
    progress = Progress(f"train {task} on {backend}, seed {seed}", steps)
    model.learn(max(0, steps - done), callback=[checkpoint, progress], reset_num_timesteps=not done)
    origin = Origin(**{field.name: getattr(settings, field.name) for field in fields(Origin)})
    policy = export(model.policy, origin, out / "policy.onnx")
    last = [reward for _, reward in checkpoint.curve[-LAST:]]
    result = {
        "policy": str(policy), "steps": model.num_timesteps, "reward": float(np.mean(last)) if last else None,
        "seconds": progress.seconds, "curve": checkpoint.curve,
    }  # fmt: skip
    (out / "training.json").write_text(json.dumps({"settings": asdict(settings), **result}, indent=1) + "\n")
    return result


def ppo(settings: Settings, env: HamrVecEnv) -> PPO:
    """A fresh learner."""
    network = {
        "features_extractor_class": Normalise, "features_extractor_kwargs": {"view": settings.view}, "net_arch": list(settings.hidden),
        "activation_fn": torch.nn.ELU, "log_std_init": settings.log_std,
    }  # fmt: skip
    return PPO(
        "MlpPolicy", env, learning_rate=lambda remaining: settings.learning_rate * max(0.0, remaining), n_steps=settings.rollout,
        batch_size=settings.batch, n_epochs=settings.epochs, gamma=settings.gamma, gae_lambda=settings.gae_lambda,
        stats_window_size=settings.robots * settings.rollout, policy_kwargs=network, seed=settings.seed, device="cpu",
    )  # fmt: skip
