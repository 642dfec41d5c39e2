"""Laws of geometry: how inertia, stiffness and drive change with the angles, and how the two joints hang together."""

from __future__ import annotations

import math

from hamr_description.simple_constants import simple_constants

from ..machine import actuator_stiffness
from .law import ANY, ARMATURE, BOTH, EACH, GAIN, TAU, TIP, Q, U, V, law


def _lever(parameters, dt):
    bend = parameters.get("angle", parameters.get("bend"))
    return math.copysign(bend, parameters["side"]), *actuator_stiffness(), *simple_constants()["front"]["tip_per_angle"]


@law("configuration_dependent_transmission", size="angle", prepare=_lever, places=ANY, angle=(0.02, 1.0), side=(-1.0, 1.0))
def crank(i, t, dt, w, p, s):
    """A crank off its best angle at rest: tip = ratio (sin(q + b) - sin b) / cos b; the drive and the bimorph's spring go through it."""
    q, scale = w[Q + i], 1.0 / math.cos(p[0])
    travel, lever = (math.sin(q + p[0]) - math.sin(p[0])) * scale, math.cos(q + p[0]) * scale
    w[TAU + i] += w[GAIN + i] * w[U + i] * (lever - 1.0) - p[1 + i] * (travel * lever - q)
    w[TIP + i] = p[3 + i] * travel


@law("configuration_dependent_transmission", size="bend", prepare=_lever, places=ANY, bend=(0.02, 1.2), side=(-1.0, 1.0))  # fmt: skip
def cam(i, t, dt, w, p, s):
    """An exponential cam: tip = ratio (exp(b q) - 1) / b."""
    q = w[Q + i]
    lever = math.exp(p[0] * q)
    travel = math.expm1(p[0] * q) / p[0]
    w[TAU + i] += w[GAIN + i] * w[U + i] * (lever - 1.0) - p[1 + i] * (travel * lever - q)
    w[TIP + i] = p[3 + i] * travel


@law("configuration_dependent_transmission", size="softening", softening=(2e-5, 5e-3))
def voltage_spring(i, t, dt, w, p, s):
    """A spring that the voltage tunes: torque by voltage times angle."""
    w[TAU + i] -= p[0] * w[U + i] * w[Q + i]


@law("configuration_dependent_inertia", size="mass", places=EACH, mass=(0.01, 2.5), throw=(0.4, 1.5), phase=(-0.8, 0.8))
def sliding_mass(i, t, dt, w, p, s):
    """A mass whose radius follows the joint's own angle: J = mass (1 + throw sin(q + phase))^2, with its centrifugal torque."""
    x = w[Q + i] + p[2]
    radius, slope = 1.0 + p[1] * math.sin(x), p[1] * math.cos(x)
    w[ARMATURE + i] += p[0] * radius * radius
    w[TAU + i] -= p[0] * radius * slope * w[V + i] * w[V + i]


@law(
    "configuration_dependent_inertia", size="mass", places=(BOTH,), mass=(0.01, 2.5), throw=(0.5, 2.0), phase=(-0.8, 0.8), host=(-1.0, 1.0)
)
def pirouette(i, t, dt, w, p, s):
    """A mass that turns with one joint at a radius set by the other (host > 0: it turns with swing)."""
    turning = 0 if p[3] > 0.0 else 1
    x = w[Q + 1 - turning] + p[2]
    radius, slope = 1.0 + p[1] * math.sin(x), p[1] * math.cos(x)
    if i == turning:
        w[ARMATURE + i] += p[0] * radius * radius
        w[TAU + i] -= 2.0 * p[0] * radius * slope * w[V + 1 - i] * w[V + i]
    else:
        w[TAU + i] += p[0] * radius * slope * w[V + turning] * w[V + turning]


@law(
    "configuration_dependent_stiffness",
    size="depth",
    places=EACH,
    depth=(2e-3, 3.0),
    centre=(0.08, 0.35),
    width=(0.08, 0.3),
    side=(-1.0, 1.0),
)
def valley(i, t, dt, w, p, s):
    """The potential depth width log cosh((q - centre) / width), a spring near the centre, a constant force far off; none at rest."""
    centre = math.copysign(p[1], p[3])
    w[TAU + i] -= p[0] * (math.tanh((w[Q + i] - centre) / p[2]) + math.tanh(centre / p[2]))


@law(
    "configuration_dependent_stiffness",
    size="depth",
    places=(BOTH,),
    depth=(2e-3, 3.0),
    mix=(0.4, 1.2),
    centre=(-0.2, 0.2),
    width=(0.1, 0.35),
)
def slanted_valley(i, t, dt, w, p, s):
    """The same across both angles: the potential is a function of cos(mix) swing + sin(mix) lift."""
    along, across = math.cos(p[1]), math.sin(p[1])
    x = along * w[Q] + across * w[Q + 1]
    force = p[0] * (math.tanh((x - p[2]) / p[3]) + math.tanh(p[2] / p[3]))
    w[TAU + i] -= force * (along if i == 0 else across)


@law("configuration_dependent_stiffness", size="depth", depth=(2e-4, 0.2), centre=(0.03, 0.2), width=(0.012, 0.04), side=(-1.0, 1.0))
def snap(i, t, dt, w, p, s):
    """A narrow hump in the potential: stiffness turns negative on its top."""
    x = (w[Q + i] - math.copysign(p[1], p[3])) / p[2]
    w[TAU + i] += p[0] * x * math.exp(-0.5 * x * x)


@law("configuration_dependent_stiffness", size="pull", places=(BOTH,), pull=(2e-3, 6.0))
def three_waves(i, t, dt, w, p, s):
    """Energy passed between the joints at third order: potential pull swing lift (swing - lift)."""
    a, b = w[Q], w[Q + 1]
    w[TAU + i] -= p[0] * (2.0 * a * b - b * b if i == 0 else a * a - 2.0 * a * b)


@law("lift_swing_coupling", size="stiffness", places=(BOTH,), stiffness=(5e-4, 0.3), sense=(-1.0, 1.0))
def cross_spring(i, t, dt, w, p, s):
    """Each joint is pulled by the other's angle."""
    w[TAU + i] -= math.copysign(p[0], p[1]) * w[Q + 1 - i]


@law("lift_swing_coupling", size="damping", places=(BOTH,), damping=(5e-4, 0.4), sense=(-1.0, 1.0))
def cross_damper(i, t, dt, w, p, s):
    """Each joint is dragged by the other's rate."""
    w[TAU + i] -= math.copysign(p[0], p[1]) * w[V + 1 - i]


@law("lift_swing_coupling", size="inertia", places=(BOTH,), machine="coupled", inertia=(2e-3, 1.5), sense=(-1.0, 1.0))
def shared_flywheel(i, t, dt, w, p, s):
    """A flywheel on the sum (or difference) of the angles: MuJoCo's tendon with inertia; nothing to do here."""
