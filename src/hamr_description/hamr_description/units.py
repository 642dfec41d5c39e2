"""Conversion between the inside (g, mm, ms, N, V, quaternions wxyz) and the outside (SI, quaternions xyzw).

The only module that converts. Angles and volts are the same on both sides.
"""

from __future__ import annotations

import numpy as np

MM_PER_M = 1e3
MS_PER_S = 1e3
G_PER_KG = 1e3


def length_to_si(mm):  # mm -> m
    return mm / MM_PER_M


def length_from_si(m):  # m -> mm
    return m * MM_PER_M


def rate_to_si(per_ms):  # 1/ms -> 1/s (rad/ms -> rad/s); mm/ms equal m/s
    return per_ms * MS_PER_S


def rate_from_si(per_s):  # 1/s -> 1/ms
    return per_s / MS_PER_S


def torque_to_si(n_mm):  # N mm -> N m
    return n_mm / MM_PER_M


def mass_to_si(g):  # g -> kg
    return g / G_PER_KG


def inertia_to_si(g_mm2):  # g mm^2 -> kg m^2
    return g_mm2 / (G_PER_KG * MM_PER_M * MM_PER_M)


def time_to_si(ms):  # ms -> s
    return ms / MS_PER_S


def time_from_si(s):  # s -> ms
    return s * MS_PER_S


def quaternion_to_ros(wxyz):
    """(..., 4) wxyz -> xyzw."""
    return np.roll(wxyz, -1, axis=-1)


def quaternion_from_ros(xyzw):
    """(..., 4) xyzw -> wxyz."""
    return np.roll(xyzw, 1, axis=-1)
