"""Learning curves of trainings as a picture."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .task import TASKS


def draw_curves(trainings: Sequence[str | Path], out: str | Path) -> Path:
    """Reward of an episode against steps: one panel a task, one line a training backend: mean over seeds, and their range.

    Args:
        trainings: folders of `train.train`, of any tasks and backends.
        out: picture to write.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, len(TASKS), figsize=(10, 3.6), layout="constrained")
    for ax, task in zip(axes, TASKS, strict=True):
        for label, curves in sorted(_by_training(trainings, task).items()):
            steps = curves[0][:, 0]
            rewards = np.array([np.interp(steps, curve[:, 0], curve[:, 1]) for curve in curves])
            (line,) = ax.plot(steps, rewards.mean(axis=0), lw=1.2, label=f"{label} ({len(curves)} seeds)")
            ax.fill_between(steps, rewards.min(axis=0), rewards.max(axis=0), color=line.get_color(), alpha=0.15, lw=0)
        ax.set(title=task, xlabel="steps of 4 ms", ylabel="reward of an episode")
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
    figure.savefig(out, dpi=110)
    plt.close(figure)
    return Path(out)


def _by_training(trainings: Sequence[str | Path], task: str) -> dict[str, list[np.ndarray]]:
    """Curves (updates, 2) by what they were trained on."""
    found = defaultdict(list)
    for folder in trainings:
        report = json.loads((Path(folder) / "training.json").read_text())
        settings = report["settings"]
        if settings["task"] == task:
            found["+".join(filter(None, (settings["backend"], settings["disturbance"])))].append(np.array(report["curve"]))
    return found
