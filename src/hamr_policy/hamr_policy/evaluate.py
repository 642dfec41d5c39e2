"""Transfer: what policies do on the backend they were trained on, and on others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
import yaml
from tqdm import tqdm

from hamr_description.errors import ConfigError
from hamr_dynamics.effects.effects_file import EffectsFile
from hamr_dynamics.effects.effects_file import load as load_effects

from .backend import RESIDUAL, residual_digest, simulator
from .episodes import Episodes
from .rollout import RollOut, roll_out
from .runtime import Policy
from .task import EPISODE_S, TASKS

ENDURANCE_S = 5.0
Pair = tuple[RollOut, RollOut]  # of an episode, and of ENDURANCE_S
Place = tuple[str, str]  # backend, and hash of what is added to it


def evaluate(
    policies: Sequence[str | Path], backends: Sequence[str] = ("full",), *, residual: str | Path = "",
    effects: str | Path | EffectsFile = "", trained_with: str | Path | EffectsFile = "", rollouts: int = 5, seed: int = 0,
) -> dict:  # fmt: skip
    """Runs policies, one file a training seed, and sums up those of equal task and training.

    Args:
        policies: ONNX files.
        backends: to run on, besides the one each was trained on.
        residual: residual model file; empty for the shipped one.
        effects: effects file, what is added to `backends`; empty for nothing.
        trained_with: effects file that the policies were trained with, for the runs on their own backend; empty for none.
        rollouts: from different random starts, per policy and direction; the same starts on every backend.
        seed: of the starts.

    Returns:
        rows: [{task, direction, trained_on, run_on, quantity, unit, mean, std, n, reference, by_seed}]; trained_on and run_on end in
        "+effects" where effects were added. Quantities: speed (BL/s) or
        turning_rate (deg/s), reward (sum over 300 ms), transfer (reward over that on the training backend), upright (s of 5 before a fall).
        mean, std: over all n roll-outs, for transfer over policies. by_seed: mean of each policy.
    """
    opened = [Policy(path) for path in policies]
    added = {load_effects(file).hash: load_effects(file) for file in (effects, trained_with)}
    for policy in opened:
        _same_residual(policy, residual)
        _same_effects(policy, load_effects(trained_with))
    elsewhere = [(backend, load_effects(effects).hash) for backend in backends]
    jobs = [(policy, on) for policy in opened for on in dict.fromkeys((_home(policy), *elsewhere))]
    runs = {job: _run(*job, residual, added, rollouts, seed) for job in tqdm(jobs, desc="evaluate", disable=None)}
    groups: dict[tuple[str, Place, str, Place], list[Policy]] = defaultdict(list)
    for policy, on in jobs:
        groups[policy.about["task"], _home(policy), policy.about["disturbance"], on].append(policy)
    rows: list[dict] = []
    for (task, home, disturbance, on), members in groups.items():
        trained_on = "+".join(filter(None, (_label(home), disturbance)))
        for sign, direction in TASKS[task].directions.items():
            about = {"task": task, "direction": direction, "trained_on": trained_on, "run_on": _label(on)}
            here, there = ([runs[member, place][sign] for member in members] for place in (on, home))
            rows += [about | row for row in _rows(task, direction, here, None if on == home else there)]
    return {"rows": rows}


def _home(policy: Policy) -> Place:
    return policy.about["backend"], policy.about.get("effects", "")


def _label(place: Place) -> str:
    return "+".join(filter(None, (place[0], place[1] and "effects")))


def _run(
    policy: Policy, on: Place, residual: str | Path, added: Mapping[str, EffectsFile], rollouts: int, seed: int
) -> dict[int, Pair]:  # fmt: skip
    """Roll-outs by direction."""
    task, (backend, effects) = TASKS[policy.about["task"]], on
    sim = simulator(backend, rollouts, residual=residual if backend == RESIDUAL else "", effects=added.get(effects, ""), dtype=np.float64)
    runs = {}
    for direction in task.directions:
        episodes = Episodes(task, sim, policy.about["view"], rng=np.random.default_rng(seed))
        command = np.full(rollouts, float(direction))
        runs[direction] = roll_out(policy, episodes, command, EPISODE_S), roll_out(policy, episodes, command, ENDURANCE_S)
    return runs


def _rows(task: str, direction: str, here: list[Pair], at_home: list[Pair] | None) -> Iterator[dict]:
    figure = TASKS[task]
    yield _row(figure.quantity, figure.unit, [run.figure for run, _ in here], references()[figure.quantity][direction]["mean"])
    yield _row("reward", "1", [run.reward for run, _ in here], None)
    if at_home:
        ratios = [run.reward.mean(keepdims=True) / home.reward.mean() for (run, _), (home, _) in zip(here, at_home, strict=True)]
        yield _row("transfer", "1", ratios, None)
    yield _row("upright", "s", [run.upright for _, run in here], ENDURANCE_S)


def _row(quantity: str, unit: str, by_policy: list[np.ndarray], reference: float | None) -> dict:
    values = np.concatenate(by_policy)
    return {
        "quantity": quantity, "unit": unit, "mean": float(values.mean()), "std": float(values.std()), "n": values.size,
        "reference": reference, "by_seed": [float(v.mean()) for v in by_policy],
    }  # fmt: skip


def _same_residual(policy: Policy, residual: str | Path) -> None:
    backend, trained = policy.about["backend"], policy.about["residual"]
    if residual_digest(backend, residual) != trained:
        raise ConfigError(f"A policy was trained on another residual model ({trained}): say with which model's file, by residual.")


def _same_effects(policy: Policy, given: EffectsFile) -> None:
    trained = policy.about.get("effects", "")
    if trained and trained != given.hash:
        raise ConfigError(f"A policy was trained with effects ({trained}): say with which effects file, by trained_with.")


@cache
def references() -> dict:
    """The paper's figures: quantity -> direction -> mean, std, unit."""
    return yaml.safe_load(resources.files(__package__).joinpath("reference.yaml").read_text())
