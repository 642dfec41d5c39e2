"""The main job, end to end: one policy walks on the residual simulator, then on HAMR-full behind the same topics."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from math import pi
from pathlib import Path

from hamr_bags.reader import joint_states
from hamr_description.names import JOINTS

from .gait import Gait, gait
from .graph import Run
from .render import render
from .supervisor import up

BACKENDS = {"residual": "residual simulator", "full": "HAMR-full"}
DEGREES = 180 / pi
VIDEO_S = 1.5  # of the robot, shown slowed down


def demo(out: Path, *, policy: Path, residual: Path, seconds: float) -> dict:
    """Runs the graph as processes on both backends and reports.

    Args:
        out: folder; bags, video and plot of an earlier demo in it are replaced.
        policy: ONNX policy that walks. residual: residual model file.
        seconds: of sim time on each backend.

    Returns:
        rows: one per backend; transfer: speed on HAMR-full over speed on the residual simulator; files written; ok: both walked, none fell.
    """
    out.mkdir(parents=True, exist_ok=True)
    bags, rows = {}, []
    for backend, label in BACKENDS.items():
        sys.stderr.write(f"== {label}: simulator, controller, policy and recorder as processes, {seconds:g} s\n")
        bags[backend] = out / f"walk_{backend}"
        shutil.rmtree(bags[backend], ignore_errors=True)
        run = Run(
            backend=backend,
            residual=str(residual) if backend == "residual" else "",
            policy=str(policy),
            command="forward",
            bag=str(bags[backend]),
            seconds=seconds,
            real_time_factor=0.0,
        )
        report = up(run)
        rows.append({"backend": backend, **gait(bags[backend]).summary(), "real_time_factor": report["real_time_factor"]})
    gaits = {backend: gait(bag) for backend, bag in bags.items()}
    plot = draw(gaits, bags, out / "demo.png")
    video = render(list(bags.values()), out / "demo.mp4", labels=list(BACKENDS.values()), seconds=VIDEO_S)["video"]
    trained, real = (row["speed_bl_s"] for row in rows)
    return {
        "rows": rows,
        "transfer": real / trained if trained else 0.0,
        "bags": [str(bag) for bag in bags.values()],
        "video": video,
        "plot": str(plot),
        "ok": all(row["speed_bl_s"] > 0 and not row["fell"] and row["seconds"] >= seconds - 0.1 for row in rows),
    }


def draw(gaits: Mapping[str, Gait], bags: Mapping[str, Path], out: Path) -> Path:
    """Path, distance, height and one leg's angles on both backends."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    for backend, g in gaits.items():
        label = BACKENDS[backend]
        axes[0, 0].plot(1e3 * g.path[:, 0], 1e3 * g.path[:, 1], label=label)
        axes[0, 1].plot(g.time[1:], 1e3 * (g.forward * (g.time[1:] - g.time[:-1])).cumsum(), label=label)
        axes[1, 0].plot(g.time, 1e3 * g.height, lw=0.7, label=label)
        time, angles = joint_states(bags[backend])
        shown = time - time[0] < 0.5
        for joint, style in (("fl_swing", "-"), ("fl_lift", ":")):
            axes[1, 1].plot(time[shown] - time[0], angles[shown, JOINTS.index(joint)] * DEGREES, style, label=f"{joint}, {label}")
    titles = (("path, mm", "x", "y"), ("distance along the heading", "time, s", "mm"), ("height of the chassis frame", "time, s", "mm"),
              ("hip angles, first half second", "time, s", "deg"))  # fmt: skip
    for ax, (title, x, y) in zip(axes.flat, titles, strict=True):
        ax.set(title=title, xlabel=x, ylabel=y)
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
    axes[0, 0].set_aspect("equal", "datalim")
    figure.savefig(out, dpi=110)
    plt.close(figure)
    return out
