"""Compiled roll-outs of a leg under a torque law, with the exact derivatives of its angles.

One generated module holds the traced law, the traced step of HAMR-simple, the adjoints of both, and the loop around them. The
adjoints give the Jacobian of each step; sensitivities to weights and initial state run forward with it, 16 windows at once.
Nothing stands in for the simulator: these are the derivatives of its own 50 us step.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from hamr_description.rates import SERVO_MS
from hamr_dynamics import kernels
from hamr_dynamics.adjoint import pullback
from hamr_dynamics.emit import loop_source
from hamr_dynamics.leg_step import LANES, leg_source

from .residual_plant import torque_driven
from .series import Series

FREE = 4  # q.0 q.1 v.0 v.1: the part of a window's initial state that is fitted
STRIDE = 8  # samples averaged into one error: 0.4 ms, far below a leg's period

LOOP = """
L = {lanes}
W = {weights}
FREE = {free}
STEP = {step}


@jit
def rollout(state0, drive, goal, param, weights, columns, stride, errors, slopes):
    scratch, torque, new = np.empty(1), np.empty(2 * L), np.empty(6 * L)
    unit, jacobian, by_torque, of_param = np.empty(6 * L), np.empty((4, 6 * L)), np.empty((4, 2 * L)), np.empty(param.shape[1])
    unit2, by_state, by_weight, of_drive = np.empty(2 * L), np.empty((2, 8 * L)), np.empty((2, W * L)), np.empty(2 * L)
    s, fresh = np.empty((6, columns, L)), np.empty((4, columns, L))
    for b in range(state0.shape[0]):
        state = state0[b].copy()
        errors[b] = 0.0
        s[:] = 0.0
        for c in range(min(columns, FREE)):
            s[c, c] = 1.0
        for k in range(drive.shape[1]):
            network(state, drive[b, k], weights, scratch, torque)
            suspended(state, torque, param[b], new)
            if columns > 0:
                for i in range(2):
                    unit2[:] = 0.0
                    unit2[i * L : (i + 1) * L] = 1.0
                    network_pullback(state, drive[b, k], weights, scratch, unit2, by_state[i], by_weight[i])
                for r in range(4):
                    unit[:] = 0.0
                    unit[r * L : (r + 1) * L] = 1.0
                    suspended_pullback(state, torque, param[b], unit, jacobian[r], by_torque[r], of_param)
                    for i in range(6 * L):
                        jacobian[r, i] += by_torque[r, i % L] * by_state[0, i] + by_torque[r, L + i % L] * by_state[1, i]
                advance(jacobian, by_torque, by_weight, s, fresh)
            state[:] = new
            point = k // stride
            if point < errors.shape[1]:
                for i in range(2 * L):
                    errors[b, point, i % L, i // L] += (goal[b, k, i] - new[i]) / stride
                if k % stride == stride // 2:
                    for c in range(columns):
                        for e in range(L):
                            for i in range(2):
                                slopes[b, e, point, i, c] = s[i, c, e]


@jit
def advance(jacobian, by_torque, by_weight, s, fresh):
    '''s (rows, columns, L) of the state before the step -> of the state after it.'''
    for c in range(s.shape[1]):
        for e in range(L):
            s0, s1, s2, s3, s4, s5 = s[0, c, e], s[1, c, e], s[2, c, e], s[3, c, e], s[4, c, e], s[5, c, e]
            for r in range(4):
                j = jacobian[r]
                fresh[r, c, e] = j[e] * s0 + j[L + e] * s1 + j[2 * L + e] * s2 + j[3 * L + e] * s3 + j[4 * L + e] * s4 + j[5 * L + e] * s5
    for c in range(FREE, s.shape[1]):
        w = (c - FREE) * L
        for r in range(4):
            for e in range(L):
                fresh[r, c, e] += by_torque[r, e] * by_weight[0, w + e] + by_torque[r, L + e] * by_weight[1, w + e]
    for c in range(s.shape[1]):
        for e in range(L):
            s[4, c, e] = (fresh[2, c, e] - s[2, c, e]) / STEP
            s[5, c, e] = (fresh[3, c, e] - s[3, c, e]) / STEP
            for r in range(4):
                s[r, c, e] = fresh[r, c, e]
"""


class Rollout:
    """Roll-outs under one law, windows in blocks of 16.

    Attributes:
        stride: steps that share one error, the mean of theirs; its slope is that of the middle step.
    """

    def __init__(self, law: Series, stride: int = STRIDE) -> None:
        self.law, self.stride = law, stride
        self._module = _module(law)

    def __call__(self, windows, state0: np.ndarray, weights: np.ndarray, *, slopes: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Errors of the angles, measured minus rolled out, and their slopes.

        Args:
            windows: `dataset.Windows`. state0: (blocks, 6 * 16) initial states. weights: (W,).
            slopes: "" for none, "state" for those of the angles by the initial state, "all" for those by the weights too.

        Returns:
            (windows, points, 2) rad, each the mean of `stride` samples; (windows, points * 2, columns), columns FREE initial
            state, then weights.
        """
        blocks, steps = windows.drive.shape[:2]
        points = steps // self.stride
        columns = {"": 0, "state": FREE, "all": FREE + len(weights)}[slopes]
        errors, out = np.empty((blocks, points, LANES, 2)), np.empty((blocks, LANES, points, 2, columns))
        self._module.rollout(state0, windows.drive, windows.goal, windows.param, weights, columns, self.stride, errors, out)
        return errors.transpose(0, 2, 1, 3).reshape(blocks * LANES, points, 2), out.reshape(blocks * LANES, points * 2, columns)


@cache
def _module(law: Series):
    loop = LOOP.format(lanes=LANES, weights=len(law.rows), free=FREE, step=SERVO_MS)
    stages = law.stage(), pullback(law.stage(), ("state", "weights"))
    traced = [loop_source(stage, LANES) for stage in stages]
    return kernels.load_source(f"rollout_{law.kind}", "".join([leg_source(torque_driven(), SERVO_MS), *traced, loop]))
