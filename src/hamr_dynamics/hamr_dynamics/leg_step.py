"""LegStep: one compiled 50 us step of many independent suspended legs, with its exact derivative (training, fits)."""

from __future__ import annotations

import numpy as np

from hamr_description.rates import SERVO_MS

from . import driver, kernels, layout, leg_stages
from .adjoint import pullback
from .emit import loop_source
from .plant import Plant, flatten

LANES = 16
STATE = layout.STATE[:6]  # q v a; the stop counts carry no gradient

LOOPS = """
@jit
def step_blocks(state, drive, param, new_state):
    for b in range(state.shape[0]):
        suspended(state[b], drive[b], param[b], new_state[b])


@jit
def pullback_blocks(state, drive, param, grad, grad_state, grad_drive, grad_param):
    for b in range(state.shape[0]):
        suspended_pullback(state[b], drive[b], param[b], grad[b], grad_state[b], grad_drive[b], grad_param[b])
"""


class LegStep:
    """A plant's leg, stepped and pulled back through.

    Arrays at the interface are (rows, lanes) float64 in the leg frame: state rows q.0 q.1 v.0 v.1 a.0 a.1 (rad, rad/ms,
    rad/ms^2; a is the last acceleration, 0 to begin with), drive rows 2 (V from neutral, or N mm for a torque-driven
    leg), param rows `parameter_names`. `module` holds the same as compiled functions on blocks of 16 lanes
    ((blocks, rows * 16) arrays) for use inside compiled loops: `suspended`, `suspended_pullback`.
    """

    def __init__(self, plant: Plant, h: float = SERVO_MS) -> None:
        self.plant = plant
        self.parameter_names = layout.parameter_rows(plant)
        self.module = kernels.load_source(f"{plant.name}_leg", leg_source(plant, h))

    def step(self, state, drive, param) -> np.ndarray:
        """State after one step, (6, lanes)."""
        lanes = state.shape[1]
        new = np.empty_like(to_blocks(state))
        self.module.step_blocks(to_blocks(state), to_blocks(drive), to_blocks(param), new)
        return from_blocks(new, lanes)

    def pullback(self, state, drive, param, grad) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gradients with respect to state (6, lanes), drive (2, lanes) and parameters, given that of the new state (6, lanes)."""
        lanes = state.shape[1]
        blocks = [to_blocks(x) for x in (state, drive, param, grad)]
        out = [np.empty_like(x) for x in blocks[:3]]
        self.module.pullback_blocks(*blocks, *out)
        return tuple(from_blocks(x, lanes) for x in out)

    def parameters(self, leg: str, *, gravity: float = 0.0) -> np.ndarray:
        """(p,) parameter column of a leg (unused ground rows are zero)."""
        flat = {**dict.fromkeys(layout.ENVIRONMENT, 0.0), **flatten(self.plant.parameters(leg)), "gravity": gravity}
        return np.array([flat[name] for name in self.parameter_names])


def leg_source(plant: Plant, h: float) -> str:
    """Source of the module: step, derivative, loops over blocks."""
    stage = leg_stages.suspended_leg(plant, h)
    parts = [stage, pullback(leg_stages.suspended_leg(plant, h), ("state", "drive", "param"))]
    head = driver.HEADER.format(plant=plant.name, environment="leg", dtype="float64")
    return "".join([head, *(loop_source(s, LANES) for s in parts), LOOPS])


def to_blocks(x) -> np.ndarray:
    """(rows, lanes) -> (blocks, rows * 16); the last block is padded by repeating the last lane."""
    x = np.asarray(x, float)
    padded = np.pad(x, ((0, 0), (0, -x.shape[1] % LANES)), mode="edge")
    return np.ascontiguousarray(padded.reshape(x.shape[0], -1, LANES).transpose(1, 0, 2)).reshape(-1, x.shape[0] * LANES)


def from_blocks(x, lanes: int) -> np.ndarray:
    """Inverse of `to_blocks`."""
    rows = x.shape[1] // LANES
    return x.reshape(-1, rows, LANES).transpose(1, 0, 2).reshape(rows, -1)[:, :lanes].copy()
