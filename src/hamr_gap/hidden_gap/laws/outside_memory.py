"""Laws that no library names and that remember."""

from __future__ import annotations

import math

from .law import ANY, TAU, Q, U, V, law
from .outside import OUTSIDE, TURN


@law(OUTSIDE, size="mass", states=2, mass=(2e-3, 0.8), hertz=(12.0, 40.0), damping=(0.01, 0.06))
def absorber(i, t, dt, w, p, s):
    """A small resonator rides on the leg; s holds its angle and rate."""
    omega = TURN * p[1] * 1e-3
    pull = omega * omega * (s[0] - w[Q + i]) + 2.0 * p[2] * omega * (s[1] - w[V + i])
    s[1] -= dt * pull
    s[0] += dt * s[1]
    w[TAU + i] += p[0] * pull


def _slots(parameters, dt):
    return int(parameters["delay"] / dt) + 2


@law(OUTSIDE, size="gain", states=_slots, prepare=lambda p, dt: (p["gain"], int(p["delay"] / dt)), gain=(2e-3, 0.4), delay=(3.0, 12.0))
def echo(i, t, dt, w, p, s):
    """A torque against the rate of some time ago; s[0] is the next slot."""
    size = int(p[1]) + 1
    slot = int(s[0])
    late = s[1 + (slot + 1) % size]
    s[1 + slot] = w[V + i]
    s[0] = (slot + 1) % size
    w[TAU + i] -= p[0] * late


@law(OUTSIDE, size="softening", places=ANY, states=1, softening=(5e-3, 3.0), recovery=(150.0, 1500.0))
def stretch_memory(i, t, dt, w, p, s):
    """The joint softens with the widest recent angle and slowly recovers; nothing at first."""
    s[0] = max(abs(w[Q + i]), s[0] * math.exp(-dt / p[1]))
    w[TAU + i] += 0.55 * min(p[0] * s[0], 0.8) * w[Q + i]


@law(OUTSIDE, size="loss", loss=(5e-3, 0.7), moment=(0.25, 0.75))
def crack(i, t, dt, w, p, s):
    """At one moment (a share of 12 s) the joint loses stiffness for good."""
    if t > 12e3 * p[1]:
        w[TAU + i] += 0.55 * p[0] * w[Q + i]


@law(OUTSIDE, size="strength", states=1, strength=(2e-3, 3.0), target=(0.008, 0.03), tau=(80.0, 600.0))
def thermostat(i, t, dt, w, p, s):
    """A damping that grows while the leg is faster than `target` (rad/ms) and turns into drive while it is slower."""
    s[0] += dt / p[2] * ((w[V + i] / p[1]) ** 2 - 1.0)
    s[0] = min(max(s[0], -0.5), 3.0)
    w[TAU + i] -= 0.02 * p[0] * s[0] * w[V + i]


@law(OUTSIDE, size="share", states=2, share=(5e-3, 1.0), blink=(5.0, 25.0), pause=(60.0, 400.0))
def loose_wire(i, t, dt, w, p, s):
    """At irregular moments a share of the drive is gone for a blink (ms); s holds the moment of the next and its number."""
    while t > s[0] + p[1]:
        s[1] += 1.0
        chance = math.sin(s[1] * 12.9898) * 43758.5453
        s[0] += p[1] + p[2] * (0.2 + 1.6 * (chance - math.floor(chance)))
    if t > s[0]:
        w[U + i] *= 1.0 - p[0]


@law(OUTSIDE, size="force", states=2, force=(2e-4, 0.2), on=(30.0, 200.0), off=(60.0, 400.0))
def rubbing_cable(i, t, dt, w, p, s):
    """Friction that comes and goes at irregular moments."""
    while t > s[0]:
        s[1] += 1.0
        chance = math.sin(s[1] * 78.233) * 24634.6345
        s[0] += (p[1] if int(s[1]) % 2 else p[2]) * (0.3 + 1.4 * (chance - math.floor(chance)))
    if int(s[1]) % 2:
        w[TAU + i] -= p[0] * math.tanh(w[V + i] / 8e-4)
