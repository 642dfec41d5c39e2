"""A video of what a bag recorded, in slow motion; several bags become pictures side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from pathlib import Path

import imageio.v2 as imageio
import mujoco
import numpy as np
from tqdm import tqdm

from hamr_description import mjcf
from hamr_description.errors import ConfigError
from hamr_description.names import BASE_FRAME, JOINTS
from hamr_description.simple_constants import simple_constants

from .motion import Motion, read_motion
from .painter import Painter

FRAMES_PER_SECOND = 30
HEIGHT, WIDTH = 540, 960


def render(
    bags: Sequence[Path],
    out: Path,
    *,
    labels: Sequence[str] = (),
    slow: float = 4.0,
    seconds: float = inf,
    camera: str = "track",
) -> dict:
    """Write an .mp4 of one or more bags.

    Args:
        labels: one a bag, for its caption; default the bags' names.
        slow: seconds of video per second of the robot.
        seconds: of the robot, from the start; default all, of several bags as long as the shortest.
        camera: one of the model's cameras.

    Returns:
        {"video", "frames", "seconds" of the robot, "slow"}.

    Raises:
        BagError: a bag is damaged or has no hip angles. ConfigError: the camera or the ending of `out` is unknown.
    """
    if out.suffix != ".mp4":
        raise ConfigError(f"The video '{out}' must end in .mp4.")
    model = mujoco.MjModel.from_xml_string(mjcf.simple(simple_constants(), environment="ground"))
    cameras = [model.camera(i).name for i in range(model.ncam)]
    if camera not in cameras:
        raise ConfigError(f"The model has no camera '{camera}'; choose one of {', '.join(cameras)}.")
    motions = [read_motion(Path(bag)) for bag in bags]
    names = labels or [Path(bag).name for bag in bags]
    span = min(seconds, *(float(motion.time[-1] - motion.time[0]) for motion in motions))
    count = max(1, int(span * slow * FRAMES_PER_SECOND))
    since = np.arange(count) / (slow * FRAMES_PER_SECOND)
    width = WIDTH if len(motions) == 1 else WIDTH * 2 // 3
    painters = [Painter(model, height=HEIGHT, width=width, camera=camera) for _ in motions]
    pictures = [_pictures(model, *parts, since, slow) for parts in zip(painters, motions, names, strict=True)]
    out.parent.mkdir(parents=True, exist_ok=True)
    with imageio.get_writer(out, fps=FRAMES_PER_SECOND, codec="libx264", macro_block_size=4, ffmpeg_log_level="error") as video:
        for row in tqdm(zip(*pictures, strict=True), total=count, desc=f"render {out.name}", unit="frame", disable=None):
            video.append_data(np.hstack(row))
    return {"video": str(out), "frames": count, "seconds": span, "slow": slow}


def _pictures(model: mujoco.MjModel, painter: Painter, motion: Motion, name: str, since: np.ndarray, slow: float) -> Iterator[np.ndarray]:
    """One picture for each time in `since`, s after the motion's start."""
    time = motion.time[0] + since
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("suspended" if motion.base is None else "stand").id)
    hinges = [model.joint(joint).qposadr[0] for joint in JOINTS]
    start = model.joint(BASE_FRAME).qposadr[0]
    angles = motion.angles_at(time)
    base = np.tile(data.qpos[start : start + 7], (len(time), 1)) if motion.base is None else np.hstack(motion.base_at(time))
    for i, seconds in enumerate(since):
        data.qpos[hinges] = angles[i]
        data.qpos[start : start + 7] = base[i]
        mujoco.mj_forward(model, data)
        yield painter.frame(data, base[: i + 1, :2], f"{name}   {seconds:.2f} s   {slow:g} x slower")
