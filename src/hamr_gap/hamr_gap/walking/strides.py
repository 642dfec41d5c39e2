"""Strides: how far and round each one takes the robot, measured and simulated from each stride's own start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hamr_description.names import JOINTS
from hamr_description.units import length_to_si

from .replay import Replay
from .robot import Robot
from .segments import Segments, moved, segments
from .setting import Setting
from .starts import start
from .walk import Walk

LEAD = JOINTS[1]  # the drive whose rise begins a stride
LONGEST_MS = 150.0
SHORTEST_MS = 15.0
FIRST_MS = 24.0  # of a stride, on which its start is fitted
QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
MOST = 60


def strides(walk: Walk, robot: Robot, models: Mapping[str, Setting]) -> dict:
    """Quantiles of length (m) and yaw (rad) per stride: {"strides": n, "quantiles": [...], "length": {who: [...]}, "yaw": {...}}.

    "measured", and each model by its name; empty where no drive has strides.
    """
    begins, lasts = _cycles(walk)
    if len(begins) < 8:
        return {}
    longest = int(lasts.max())
    whole = segments(walk, length_ms=longest * walk.step, every_ms=SHORTEST_MS)
    near = np.abs(whole.first[:, None] - begins).argmin(0)
    near = np.unique(near)
    index = near[np.unique(np.linspace(0, len(near) - 1, min(len(near), MOST)).astype(int))]
    chosen = whole.some(index)
    length = lasts[np.abs(chosen.first[:, None] - begins).argmin(1)]
    ends = np.array([np.abs(walk.seen - (f + n)).argmin() for f, n in zip(chosen.first, length, strict=True)])
    first = np.searchsorted(walk.seen, chosen.first)
    samples = np.maximum(walk.seen[ends] - chosen.first, 1)
    found = {"measured": _moves(walk.position[first], walk.quaternion[first], walk.position[ends], walk.quaternion[ends])}
    for name, model in models.items():
        found[name] = _simulated(robot, chosen, model, samples)
    table = {what: {who: np.quantile(x[k], QUANTILES).tolist() for who, x in found.items()} for k, what in enumerate(("length", "yaw"))}
    return {"strides": len(chosen), "quantiles": list(QUANTILES), **table}


def _cycles(walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Samples at which strides begin, and how long each lasts."""
    u = walk.voltages[:: len(walk.voltages) // len(walk.angles), JOINTS.index(LEAD)]
    u = u - np.median(u)
    rises = np.flatnonzero((u[:-1] < 0) & (u[1:] >= 0)) + 1
    lasts = np.diff(rises)
    good = (lasts * walk.step > SHORTEST_MS) & (lasts * walk.step < LONGEST_MS)
    return rises[:-1][good], lasts[good]


def _simulated(robot: Robot, chosen: Segments, model: Setting, samples: np.ndarray) -> np.ndarray:
    short = Replay.of(robot, replace(chosen, samples=round(FIRST_MS / chosen.walk.step)))
    change = start(short, model).change
    starts = moved(chosen.starts, change * chosen.sd)
    drives, n = Replay.of(robot, chosen).observed.drives, len(chosen)
    runs = robot.run(starts, drives, [model], np.zeros(n, int), np.arange(n))
    at = np.minimum(samples, chosen.samples) - 1
    return _moves(starts[:, :3], starts[:, 3:7], runs.position[np.arange(n), at], runs.quaternion[np.arange(n), at])


def _moves(position: np.ndarray, quaternion: np.ndarray, end: np.ndarray, last: np.ndarray) -> np.ndarray:
    """(2, n) m along the first heading, and rad of yaw."""
    yaw = _yaw(quaternion)
    way = end - position
    return np.stack([length_to_si(way[:, 0] * np.cos(yaw) + way[:, 1] * np.sin(yaw)), np.angle(np.exp(1j * (_yaw(last) - yaw)))])


def _yaw(quaternion: np.ndarray) -> np.ndarray:
    w, x, y, z = quaternion.T
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
