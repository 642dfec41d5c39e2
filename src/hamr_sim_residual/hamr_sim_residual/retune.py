"""HAMR-simple re-tuned on the same data: the fair baseline for a residual, as it may change every parameter but no structure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from hamr_description.rates import SERVO_MS
from hamr_dynamics.leg_step import LegStep, from_blocks
from hamr_dynamics.plant import Plant, flatten, unflatten

from .dataset import Stretch, Windows, windows
from .plants import simple

PARAMETERS = ("stiffness", "damping", "torque_per_volt", "inertia")
KEPT = "torque_per_volt.0"
HORIZON_MS = 8.0
EVERY = 20  # of the steps, compared


def retuned(parts: Sequence[Stretch]) -> Plant:
    """HAMR-simple with the factors on stiffness, damping, torque per volt and inertia that fit roll-outs of 8 ms best.

    One factor for each number, common to the four legs; least squares over all windows from their smoothed initial states. The
    motion depends on the ratios of these numbers alone, so swing's torque per volt stays.
    """
    plant = simple()
    step = LegStep(plant)
    data = windows(parts, round(HORIZON_MS / SERVO_MS), step)
    names = [name for name in flatten(plant.parameters("fl")) if name.split(".")[0] in PARAMETERS and name != KEPT]
    rows = [step.parameter_names.index(name) for name in names]

    def residual(factors: np.ndarray) -> np.ndarray:
        return _roll(step, data, rows, factors).ravel()

    fit = least_squares(residual, np.ones(len(names)), method="lm", max_nfev=12 * (len(names) + 1))

    def parameters(leg: str) -> dict:
        like = plant.parameters(leg)
        flat = flatten(like)
        return unflatten(flat | {name: flat[name] * factor for name, factor in zip(names, fit.x, strict=True)}, like)

    return Plant("simple", plant.leg, parameters, plant.chassis, plant.tunable)


def _roll(step: LegStep, data: Windows, rows: list[int], factors: np.ndarray) -> np.ndarray:
    lanes = data.state0.shape[0] * data.state0.shape[1] // 6
    state, param = from_blocks(data.state0, lanes), from_blocks(data.param, lanes)
    param[rows] *= factors[:, None]
    errors = []
    for k in range(data.drive.shape[1]):
        state = step.step(state, from_blocks(data.drive[:, k], lanes), param)
        if (k + 1) % EVERY == 0:
            errors.append(state[:2] - from_blocks(data.goal[:, k], lanes))
    return np.array(errors)
