"""Memory of the piezo: hysteresis by play operators or Coleman and Hodgdon's equation, creep by spectra of slow elements."""

from __future__ import annotations

import math

import numpy as np

from .law import ANY, U, law

PLAYS, SLOW = 8, 9
#: Times of creep, ms, and their distance in decades.
TAU, SPACING = np.geomspace(20.0, 2e5, SLOW), 0.5


def _plays(parameters, dt):
    radii = np.linspace(0.06, 1.0, PLAYS) * parameters["reach"]
    weights = np.exp(-radii / parameters["reach"] * parameters["steepness"])
    return parameters["loop"], *radii, *(weights / weights.sum())


@law("piezo_hysteresis", size="loop", places=ANY, states=PLAYS, prepare=_plays, loop=(0.005, 0.9), reach=(30.0, 110.0),
     steepness=(0.3, 3.0))  # fmt: skip
def play_sum(i, t, dt, w, p, s):
    """Plays of eight widths take over a share `loop` of the voltage."""
    u, total = w[U + i], 0.0
    for k in range(PLAYS):
        s[k] = min(max(s[k], u - p[1 + k]), u + p[1 + k])
        total += p[1 + PLAYS + k] * s[k]
    w[U + i] = u + p[0] * (total - u)


@law("piezo_hysteresis", size="loop", places=ANY, states=2, loop=(0.005, 0.9), scale=(15.0, 150.0))
def coleman_hodgdon(i, t, dt, w, p, s):
    """A part that follows over volts travelled, not over time: dx = |du| (u - x) / scale, exact for u linear in between."""
    u, before = w[U + i], s[1]
    path = abs(u - before)
    if path > 0.0:
        keep, slope = math.exp(-path / p[1]), (u - before) / path * p[1]
        s[0] = u - slope + (s[0] - before + slope) * keep
    s[1] = u
    w[U + i] = u + p[0] * (s[0] - u)


def _log_times(parameters, dt):
    return *-np.expm1(-dt / TAU), *np.full(SLOW, parameters["per_decade"] * SPACING)


def _power_times(parameters, dt):
    return *-np.expm1(-dt / TAU), *(parameters["per_decade"] * SPACING * (TAU / 1000.0) ** parameters["exponent"])


@law("piezo_creep", size="per_decade", places=ANY, states=SLOW, prepare=_log_times, per_decade=(0.002, 0.6))
def log_creep(i, t, dt, w, p, s):
    """Two elements per decade of time, equal: a step's answer grows with log t."""
    u, more = w[U + i], 0.0
    for k in range(SLOW):
        s[k] += p[k] * (u - s[k])
        more += p[SLOW + k] * s[k]
    w[U + i] = u + more


@law("piezo_creep", size="per_decade", places=ANY, states=SLOW, prepare=_power_times, per_decade=(0.002, 0.6), exponent=(0.1, 0.35))
def power_creep(i, t, dt, w, p, s):
    """As log_creep with weights that grow as a power of time; per_decade is that at 1 s."""
    u, more = w[U + i], 0.0
    for k in range(SLOW):
        s[k] += p[k] * (u - s[k])
        more += p[SLOW + k] * s[k]
    w[U + i] = u + more
