"""Laws between the drive voltage and the torque: they overwrite the effective voltage U (V about neutral)."""

from __future__ import annotations

import math

from .law import ANY, BOTH, COMMAND, EACH, U, law


@law("drive_lag", size="tau", places=ANY, states=1, tau=(0.01, 10.0))
def exact_lag(i, t, dt, w, p, s):
    """First order, solved exactly over the step: its end goes to the state, its mean to the drive."""
    keep = math.exp(-dt / p[0])
    start, goal = s[0], w[U + i]
    w[U + i] = goal + (start - goal) * (1.0 - keep) * p[0] / dt
    s[0] = goal + (start - goal) * keep


@law("drive_lag", size="tau", places=ANY, states=2, tau=(0.01, 10.0), second=(0.05, 0.15))
def cable_and_amplifier(i, t, dt, w, p, s):
    """Two real poles, the second one fast."""
    for k in range(2):
        tau = p[0] if k == 0 else p[0] * p[1]
        keep = math.exp(-dt / tau)
        start, goal = s[k], w[U + i]
        w[U + i] = goal + (start - goal) * (1.0 - keep) * tau / dt
        s[k] = goal + (start - goal) * keep


def _slots(parameters, dt):
    return int(parameters["tau"] / dt) + 4


def _delay_numbers(parameters, dt):
    whole = int(parameters["tau"] / dt)
    return whole, parameters["tau"] / dt - whole, whole + 3


@law("drive_delay", size="tau", places=EACH, states=_slots, prepare=_delay_numbers, tau=(0.02, 8.0))
def ring_buffer(i, t, dt, w, p, s):
    """The mean over the step of the voltage tau ago, exact for voltages held over steps; s[0] is the next slot."""
    whole, size = int(p[0]), int(p[2])
    slot = int(s[0])
    s[1 + slot] = w[U + i]
    late = s[1 + (slot - whole) % size]
    later = s[1 + (slot - whole - 1) % size]
    w[U + i] = (1.0 - p[1]) * late + p[1] * later
    s[0] = (slot + 1) % size


@law("drive_saturation", size="depth", places=ANY, depth=(0.02, 0.9), side=(-1.0, 1.0))
def hard_clip(i, t, dt, w, p, s):
    """A rail short of the full range; a third of the draws each: both sides, high only, low only."""
    level = 112.5 * (1.0 - p[0])
    if p[1] > -0.33:
        w[U + i] = min(w[U + i], level)
    if p[1] < 0.33:
        w[U + i] = max(w[U + i], -level)


@law("drive_saturation", size="bend", places=ANY, bend=(0.05, 4.0))
def arctan_clip(i, t, dt, w, p, s):
    """Soft: the slope falls from 1 as bend * u / 112.5 V nears 1."""
    scale = 112.5 / p[0]
    w[U + i] = scale * math.atan(w[U + i] / scale)


@law("voltage_dependent_gain", size="rise", places=ANY, rise=(0.005, 1.2), middle=(15.0, 80.0), width=(4.0, 25.0), side=(-1.0, 1.0))
def sigmoid_field(i, t, dt, w, p, s):
    """The piezo coefficient climbs a sigmoid of the field, of both signs alike or, for side > 0.4, of the signed field."""
    field = w[U + i] if p[3] > 0.4 else abs(w[U + i])
    w[U + i] *= 1.0 + p[0] / (1.0 + math.exp(-(field - p[1]) / p[2]))


@law("voltage_dependent_gain", size="power", places=ANY, power=(0.005, 0.8))
def power_field(i, t, dt, w, p, s):
    """The coefficient grows as a small power of the field."""
    w[U + i] *= (abs(w[U + i]) / 112.5) ** p[0]


@law("rail_crosstalk", size="share", places=EACH, share=(0.002, 0.5))
def neighbour(i, t, dt, w, p, s):
    """A share of the other channel's voltage."""
    w[U + i] += p[0] * w[COMMAND + 1 - i]


@law("rail_crosstalk", size="share", places=(BOTH,), share=(0.002, 0.4))
def rail_droop(i, t, dt, w, p, s):
    """The common rail sags with what both channels ask for."""
    w[U + i] -= p[0] * (w[COMMAND] + w[COMMAND + 1])


@law("drive_drift", size="loss", places=ANY, loss=(0.005, 0.8), tau=(1500.0, 2e4))
def fade(i, t, dt, w, p, s):
    """The gain decays to 1 - loss."""
    w[U + i] *= 1.0 - p[0] * (1.0 - math.exp(-t / p[1]))


@law("drive_drift", size="swing", places=ANY, swing=(0.005, 0.6), period=(5e3, 2e4), phase=(-3.1, 3.1), ratio=(2.2, 3.4))
def wander(i, t, dt, w, p, s):
    """The gain wanders: two slow waves."""
    turn = 6.283185307179586 * t / p[1]
    w[U + i] *= 1.0 + p[0] * (math.sin(turn + p[2]) + 0.5 * math.sin(p[3] * turn))


@law("drive_drift", size="loss", places=ANY, states=1, loss=(0.01, 1.5), tau=(300.0, 1500.0))
def self_heating(i, t, dt, w, p, s):
    """The gain falls with the heat that the voltage squared leaves, in units of (50 V)^2."""
    s[0] += dt / p[1] * ((w[U + i] / 50.0) ** 2 - s[0])
    w[U + i] /= 1.0 + p[0] * s[0]
