"""Walks in MuJoCo, as an instrumented robot would have given them."""

from __future__ import annotations

from functools import cache

import numpy as np

from hamr_bags.as_measured import NOISE, strokes
from hamr_bags.excitation import excitation
from hamr_description.names import JOINTS, Topic
from hamr_gap.walking.walk import Walk, turned

SECONDS = 1.2
STEP = 0.25  # ms


@cache
def walked(scatter: float = 1.0) -> tuple[Walk, np.ndarray]:
    """A trot, with `scatter` times the sensors' noise: what was measured, and the true states at each pose."""
    return driven(excitation("trot", seconds=SECONDS, frequency_hz=16.0, amplitude=40.0).voltages, scatter)


def driven(volts: np.ndarray, scatter: float = 1.0) -> tuple[Walk, np.ndarray]:
    """The same under voltages (n, 8) at 20 kHz, of which every fifth is recorded."""
    from hamr_sim_residual.mujoco_simple import simple_engine

    engine, states, angles = simple_engine(), [], []
    order = [engine.model.joint(joint).dofadr[0] - 6 for joint in JOINTS]
    for k, v in enumerate(volts):
        q, rates = engine.data.qpos[7:], engine.data.qvel[6:]
        if k % 5 == 0:
            angles.append(q[order].copy())
        if k % 80 == 0:
            states.append(np.concatenate([engine.data.qpos[:7], engine.data.qvel[:6], q[order], rates[order]]))
        engine.substep(v)
    return _measured(volts[::5], np.array(angles), np.array(states), scatter), np.array(states)


def _measured(volts: np.ndarray, angles: np.ndarray, states: np.ndarray, scatter: float) -> Walk:
    rng = np.random.default_rng(1)
    n, encoder = len(states), scatter * NOISE * strokes()[Topic.SERVO_JOINTS]
    quaternion = turned(states[:, 3:7], rng.normal(0, scatter * 2e-3, (n, 3)))
    position = states[:, :3] + rng.normal(0, scatter * 0.05, (n, 3))
    return Walk(volts, angles + rng.normal(0, encoder, angles.shape), STEP, 16 * np.arange(n), position, quaternion)
