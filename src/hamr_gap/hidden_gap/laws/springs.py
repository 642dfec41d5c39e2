"""Elastic laws of one joint: hardening, stops inside the travel, relaxing springs, lost motion and give in the drive train."""

from __future__ import annotations

import math

import numpy as np

from .law import ANY, RQ, RTAU, RV, TAU, Q, V, law

STIFF = 0.01  # ms
LADDER = 13
SLIDERS = 8
ROTOR = 0.03  # g mm^2, about the inertia of the actuator's own hinge: scale for contact damping


@law("cubic_stiffness", size="stiffness", places=ANY, stiffness=(5e-3, 12.0), width=(0.12, 0.5))
def sinh_spring(i, t, dt, w, p, s):
    """Hardening as sinh x - x."""
    x = max(min(w[Q + i] / p[1], 8.0), -8.0)
    w[TAU + i] -= p[0] * p[1] * (math.sinh(x) - x)


@law("cubic_stiffness", size="stiffness", places=ANY, stiffness=(5e-3, 40.0), softening=(-1.0, 1.0))
def cube(i, t, dt, w, p, s):
    """x^3, hardening; for softening > 0.5 the reverse, which turns back beyond 0.45 rad."""
    q = w[Q + i]
    if p[1] > 0.5:
        q = max(min(q, 0.45), -0.45)
        w[TAU + i] += min(p[0], 1.5) * q * q * q
    else:
        w[TAU + i] -= p[0] * q * q * q


@law("end_stop", size="depth", places=ANY, step=STIFF, depth=(0.03, 0.92), stiffness=(3.0, 80.0), loss=(2.0, 30.0), side=(-1.0, 1.0))
def hunt_crossley(i, t, dt, w, p, s):
    """A Hertzian stop with Hunt and Crossley's loss, inside 0.55 rad by `depth`; both sides or one."""
    q, v, place = w[Q + i], w[V + i], 0.55 * (1.0 - p[0])
    if q > place and p[3] > -0.33:
        w[TAU + i] -= max(0.0, p[1] * (q - place) ** 1.5 * (1.0 + p[2] * v))
    if q < -place and p[3] < 0.33:
        w[TAU + i] += max(0.0, p[1] * (-place - q) ** 1.5 * (1.0 - p[2] * v))


@law("end_stop", size="depth", places=ANY, step=STIFF, depth=(0.03, 0.92), stiffness=(1.0, 15.0), width=(0.02, 0.08), side=(-1.0, 1.0))
def rubber(i, t, dt, w, p, s):
    """A bumper whose force grows exponentially with depth."""
    q, place = w[Q + i], 0.55 * (1.0 - p[0])
    if q > place and p[3] > -0.33:
        w[TAU + i] -= p[1] * p[2] * (math.exp(min((q - place) / p[2], 5.0)) - 1.0)
    if q < -place and p[3] < 0.33:
        w[TAU + i] += p[1] * p[2] * (math.exp(min((-place - q) / p[2], 5.0)) - 1.0)


def _ladder(parameters, dt):
    """Relaxation times over four decades, three per decade; stiffness ~ tau^-exponent, so that loss ~ omega^exponent."""
    tau = np.geomspace(0.16, 1600.0, LADDER)
    share = 2.0 / np.pi * np.log(tau[1] / tau[0])  # sum of x / (1 + x^2) over the ladder times this is 1
    exponent = parameters.get("exponent", 0.0)
    return *-np.expm1(-dt / tau), *(parameters["loss"] * share * (tau / 4.0) ** -exponent)


@law("structural_damping", size="loss", places=ANY, states=LADDER, prepare=_ladder, loss=(5e-4, 0.4))
def relaxation_ladder(i, t, dt, w, p, s):
    """Thirteen Maxwell elements whose loss modulus (N mm/rad) is the same from 1 to 100 Hz."""
    torque = 0.0
    for k in range(LADDER):
        s[k] += p[k] * (w[Q + i] - s[k])
        torque += p[LADDER + k] * (w[Q + i] - s[k])
    w[TAU + i] -= torque


@law("structural_damping", size="loss", places=ANY, states=LADDER, prepare=_ladder, loss=(5e-4, 0.4), exponent=(0.05, 0.25))
def fractional(i, t, dt, w, p, s):
    """The same ladder for a small fractional power of frequency."""
    torque = 0.0
    for k in range(LADDER):
        s[k] += p[k] * (w[Q + i] - s[k])
        torque += p[LADDER + k] * (w[Q + i] - s[k])
    w[TAU + i] -= torque


@law("viscoelasticity", size="stiffness", places=ANY, states=1, stiffness=(2e-3, 0.8), tau=(2.0, 1000.0))
def standard_solid(i, t, dt, w, p, s):
    """A Maxwell element beside the joint's own spring."""
    old = s[0]
    s[0] += -math.expm1(-dt / p[1]) * (w[Q + i] - old)
    w[TAU + i] -= p[0] * (w[Q + i] - s[0])


@law("viscoelasticity", size="stiffness", places=ANY, states=2, stiffness=(2e-3, 0.8), fast=(1.0, 10.0), slow=(50.0, 1000.0),
     share=(0.3, 0.8))  # fmt: skip
def two_times(i, t, dt, w, p, s):
    """Two Maxwell elements, a fast and a slow one."""
    for k in range(2):
        s[k] += -math.expm1(-dt / p[1 + k]) * (w[Q + i] - s[k])
        w[TAU + i] -= p[0] * (p[3] if k == 0 else 1.0 - p[3]) * (w[Q + i] - s[k])


@law("spring_hysteresis", size="stiffness", places=ANY, states=SLIDERS, stiffness=(2e-3, 3.0), reach=(0.1, 0.8))
def iwan(i, t, dt, w, p, s):
    """Springs in series with dry sliders, side by side; the sliders yield one after the other, evenly spread up to a twist of `reach`."""
    torque = 0.0
    for k in range(SLIDERS):
        limit = p[1] * (k + 0.5) / SLIDERS
        s[k] = max(min(s[k], w[Q + i] + limit), w[Q + i] - limit)
        torque += p[0] / SLIDERS * (w[Q + i] - s[k])
    w[TAU + i] -= torque


@law("spring_hysteresis", size="stiffness", places=ANY, states=1, stiffness=(2e-3, 3.0), reach=(0.05, 0.4), back=(3.0, 9.0),
     power=(1.2, 3.0))  # fmt: skip
def bouc_wen_power(i, t, dt, w, p, s):
    """Bouc and Wen's equation with any exponent, and a curve that is steeper on the way back than on the way out."""
    way = dt * w[V + i] / p[1]
    middle = s[0] + 0.5 * way * (1.0 - (1.0 if way * s[0] > 0.0 else -p[2]) * abs(s[0]) ** p[3])
    new = s[0] + way * (1.0 - (1.0 if way * middle > 0.0 else -p[2]) * abs(middle) ** p[3])
    w[TAU + i] -= p[0] * p[1] * 0.5 * (s[0] + new)
    s[0] = new


@law("backlash", size="gap", machine="series", step=STIFF, gap=(2e-4, 0.2), stiffness=(300.0, 1000.0), loss=(5.0, 40.0))
def hertz_play(i, t, dt, w, p, s):
    """Lost motion between actuator and leg, total width `gap`, with Hertzian flanks that lose energy."""
    x, rate = w[RQ + i] - w[Q + i], w[RV + i] - w[V + i]
    side = math.copysign(1.0, x)
    depth = side * x - 0.5 * p[0]
    if depth > 0.0:
        drag = p[1] * depth**1.5 * p[2] + 0.2 * math.sqrt(p[1] * ROTOR * math.sqrt(depth))
        push = side * max(0.0, p[1] * depth**1.5 + drag * side * rate)
        w[TAU + i] += push
        w[RTAU + i] -= push


@law("serial_compliance", size="compliance", machine="series", step=STIFF, compliance=(0.012, 4.0), damping=(0.05, 0.5))
def soft_coupling(i, t, dt, w, p, s):
    """A spring and damper (share of the critical one) between actuator and leg; the leg alone has the flexures."""
    stiffness = 1.0 / p[0]
    push = stiffness * (w[RQ + i] - w[Q + i]) + 2.0 * p[1] * math.sqrt(stiffness * ROTOR) * (w[RV + i] - w[V + i])
    w[TAU + i] += push
    w[RTAU + i] -= push


@law("serial_compliance", size="compliance", machine="series", step=STIFF, compliance=(0.012, 4.0), hardening=(0.5, 8.0))
def leaf_coupling(i, t, dt, w, p, s):
    """As soft_coupling, stiffening with its twist, lightly damped."""
    x, stiffness = w[RQ + i] - w[Q + i], 1.0 / p[0]
    push = stiffness * x * (1.0 + p[1] * x * x) + 0.3 * math.sqrt(stiffness * ROTOR) * (w[RV + i] - w[V + i])
    w[TAU + i] += push
    w[RTAU + i] -= push
