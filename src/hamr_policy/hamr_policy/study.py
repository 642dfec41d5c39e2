"""The paper's comparison, asked here: how well do policies walk and turn on HAMR-full, by what they were trained on?

`python -m hamr_policy.study --out out/study` trains every policy of TRAININGS that is not there yet, rolls all of them out, and writes
the tables of docs/policies.md to standard output.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import tyro

from hamr_description.errors import ConfigError

from .evaluate import evaluate, references
from .task import TASKS
from .train import train

#: Arguments of `train.train` by name of the training. The first is the question; all others are what it is compared with.
TRAININGS: dict[str, dict[str, str]] = {
    "residual": {"backend": "residual"},
    "full": {"backend": "full"},
    "simple": {"backend": "simple"},
    "simple_published": {"backend": "simple_published"},
    "simple+noise": {"backend": "simple", "disturbance": "noise"},
    "simple+randomised": {"backend": "simple", "disturbance": "randomised"},
    "residual+nowhere": {"backend": "residual", "view": "nowhere"},
    "residual+place": {"backend": "residual", "view": "place"},
}
DIRECTIONS = [direction for task in TASKS.values() for direction in task.directions.values()]
TARGET = "full"
Rows = dict[tuple[str, str, str], dict]  # of `evaluate.evaluate`, by direction, simulator and quantity


def study(out: Path, trainings: Iterable[str], *, seeds: int, steps: int) -> dict[str, Rows]:
    """Trains what is missing in a folder, and evaluates all; by name of the training."""
    found = {}
    for name in trainings:
        if name not in TRAININGS:
            raise ConfigError(f"There is no training '{name}': choose from {', '.join(TRAININGS)}.")
        policies = [_policy(out, name, task, seed, steps) for task in TASKS for seed in range(seeds)]
        rows = evaluate(policies, [TARGET])["rows"]
        found[name] = {(row["direction"], row["run_on"], row["quantity"]): row for row in rows}
    return found


def _policy(out: Path, name: str, task: str, seed: int, steps: int) -> Path:
    folder = out / f"{task}_{name}_{seed}"
    path = folder / "policy.onnx"
    if not path.exists():
        train(task, out=folder, seed=seed, steps=steps, resume=True, **TRAININGS[name])
    return path


def speeds(found: dict[str, Rows]) -> str:
    """What robots do on HAMR-full, as a Markdown table: mean and standard deviation between seeds, and the shortest time to a fall."""
    lines = _head("trained on", "seeds", *(f"{d}, {_unit(d)}" for d in DIRECTIONS), "upright")
    for name, rows in found.items():
        figures = [rows[d, TARGET, _quantity(d)] for d in DIRECTIONS]
        upright = min(min(rows[d, TARGET, "upright"]["by_seed"]) for d in DIRECTIONS)
        lines.append(_line(name, len(figures[0]["by_seed"]), *map(_spread, figures), f"{upright:.3g} s"))
    paper = (references()[_quantity(d)][d] for d in DIRECTIONS)
    return "\n".join([*lines, _line("paper, residual", 5, *(f"{_digits(p['mean'])} +- {_digits(p['std'], 2)}" for p in paper), ""), ""])


def transfers(found: dict[str, Rows]) -> str:
    """Rewards of 300 ms where trained and on HAMR-full, and the ratio of the two, as a Markdown table."""
    lines = _head("trained on", *DIRECTIONS)
    for name, rows in found.items():
        home, cells = TRAININGS[name]["backend"], []
        for d in DIRECTIONS:
            reward = f"{rows[d, home, 'reward']['mean']:.1f}"
            if home != TARGET:
                reward += f" -> {rows[d, TARGET, 'reward']['mean']:.1f}: {_spread(rows[d, TARGET, 'transfer'])}"
            cells.append(reward)
        lines.append(_line(name, *cells))
    return "\n".join([*lines, ""])


def by_seed(rows: Rows, home: str) -> str:
    """One training in full: figures where trained and on HAMR-full, of each seed there, and whether all reach the paper's figure."""
    lines = _head("", f"on {home}", "on HAMR-full", "each seed on HAMR-full", "paper", "reached by all")
    for d in DIRECTIONS:
        here, there = (rows[d, on, _quantity(d)] for on in (home, TARGET))
        each = ", ".join(map(_digits, there["by_seed"]))
        reached = "yes" if min(there["by_seed"]) >= there["reference"] else "NO"
        lines.append(_line(f"{d}, {_unit(d)}", _spread(here), _spread(there), each, _digits(there["reference"]), reached))
    return "\n".join([*lines, ""])


def _quantity(direction: str) -> str:
    return next(task.quantity for task in TASKS.values() if direction in task.directions.values())


def _unit(direction: str) -> str:
    return next(task.unit for task in TASKS.values() if direction in task.directions.values())


def _spread(row: dict) -> str:
    by_seed = row["by_seed"]
    return _digits(row["mean"]) + (f" +- {_digits(np.std(by_seed, ddof=1), 2)}" if len(by_seed) > 1 else "")


def _digits(x: float, n: int = 3) -> str:
    return f"{float(f'{x:.{n}g}'):g}"


def _head(*cells: str) -> list[str]:
    return [_line(*cells), "|---" * len(cells) + "|"]


def _line(*cells: object) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def main(out: Path = Path("out/study"), trainings: tuple[str, ...] = tuple(TRAININGS), seeds: int = 3, steps: int = 1_000_000) -> None:
    """Trains what is missing, on one core, and writes the tables to standard output. All with 3 seeds: half an hour.

    Args:
        out: folder of all trainings; a later call goes on from what it finds there.
        trainings: names in TRAININGS; the first gets a table with each seed.
        seeds: of each training and task.
        steps: of 4 ms, of each policy.
    """
    found = study(out, trainings, seeds=seeds, steps=steps)
    first = trainings[0]
    sys.stdout.write("\n".join([by_seed(found[first], TRAININGS[first]["backend"]), speeds(found), transfers(found)]))


if __name__ == "__main__":
    tyro.cli(main)
