"""Inverse dynamics of the step: the hip torques with which HAMR-simple would have moved as measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics.leg import inertia
from hamr_dynamics.step import LegState, ahead, implicit, times2

from .simple import rigid_leg

ZERO3 = (0.0, 0.0, 0.0)


def torques(q, v, p: Mapping) -> tuple[np.ndarray, np.ndarray]:
    """Torques over each step between samples, and the last acceleration at its beginning.

    Args:
        q, v: (n + 1, 2) smoothed angles, rad, and rates, rad/ms, one sample every 50 us.
        p: `simple_parameters` of the leg.

    Returns:
        (n, 2) N mm: what takes HAMR-simple's step from v[k] to v[k + 1]; (n, 2) rad/ms^2, zero in the first row.
    """
    after = np.diff(v, axis=0) / SERVO_MS
    before = np.vstack([np.zeros((1, 2)), after[:-1]])
    return torque(q[:-1], v[:-1], before, after, p), before


def torque(q, v, before, after, p: Mapping) -> np.ndarray:
    """Torques (n, 2) under which steps from q, v with last accelerations `before` have accelerations `after`; (n, 2) each."""
    state = LegState(*(tuple(x.T) for x in (q, v, before)))
    pose, v_mid = ahead(state, SERVO_MS)
    leg = rigid_leg(pose, state.v, (0.0, 0.0), p)
    terms = inertia(leg.bodies, v_mid, ZERO3, (0.0, 0.0, value("robot.gravity")))
    push = times2(implicit(terms.leg, leg, SERVO_MS), tuple(after.T))
    return np.stack([m - f + b for m, f, b in zip(push, leg.force, terms.leg_bias, strict=True)], axis=1)
