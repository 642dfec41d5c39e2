"""Laws that no library names: they depend on time, place, way and the other channel as nobody would guess."""

from __future__ import annotations

import math

from .law import ANY, BOTH, EACH, TAU, Q, U, V, law

OUTSIDE = "outside"
TURN = 2.0 * math.pi


@law(OUTSIDE, size="depth", depth=(2e-3, 0.9), hertz=(4.0, 45.0), phase=(-3.1, 3.1))
def parametric_stiffness(i, t, dt, w, p, s):
    """Stiffness (0.55 N mm/rad of it) that pulses in time."""
    w[TAU + i] -= 0.55 * p[0] * math.sin(TURN * p[1] * t * 1e-3 + p[2]) * w[Q + i]


@law(OUTSIDE, size="damping", damping=(2e-3, 1.5))
def outward_damping(i, t, dt, w, p, s):
    """Damping on the way out only; the way home is free."""
    w[TAU + i] -= p[0] * w[V + i] * (0.5 + 0.5 * math.tanh(w[Q + i] * w[V + i] / 2e-5))


@law(OUTSIDE, size="torque", states=1, torque=(2e-4, 0.15), width=(0.02, 0.12))
def relay(i, t, dt, w, p, s):
    """A torque that snaps over when the angle has passed `width` on the other side."""
    if s[0] == 0.0 or s[0] * w[Q + i] < -p[1]:
        s[0] = math.copysign(1.0, w[Q + i])
    w[TAU + i] += p[0] * s[0]


@law(OUTSIDE, size="slowness", places=ANY, states=1, slowness=(0.01, 4.0))
def slew_limiter(i, t, dt, w, p, s):
    """The voltage changes by at most 1 / slowness V per 0.05 ms."""
    way = dt / 0.05 / p[0]
    start = s[0]
    s[0] = min(max(w[U + i], start - way), start + way)
    w[U + i] = 0.5 * (start + s[0])


@law(OUTSIDE, size="torque", torque=(2e-4, 0.15), teeth=(35.0, 110.0), phase=(-3.1, 3.1))
def cogging(i, t, dt, w, p, s):
    """Teeth."""
    w[TAU + i] += p[0] * math.sin(p[1] * w[Q + i] + p[2])


@law(OUTSIDE, size="product", product=(1e-4, 0.05))
def voltage_brake(i, t, dt, w, p, s):
    """A brake that the size of the voltage presses on."""
    w[TAU + i] -= p[0] * max(abs(w[U + i]) - 25.0, 0.0) * w[V + i]


@law(OUTSIDE, size="stiffness", stiffness=(2e-3, 0.3))
def one_way_spring(i, t, dt, w, p, s):
    """A spring that holds while the leg moves forward and lets go on the way back."""
    w[TAU + i] -= p[0] * w[Q + i] * math.tanh(w[V + i] / 2e-3)


@law(OUTSIDE, size="force", force=(2e-4, 0.2), patches=(12.0, 30.0), phase=(-3.1, 3.1))
def sticky_patches(i, t, dt, w, p, s):
    """Friction in patches of the way, none between."""
    if math.sin(p[1] * w[Q + i] + p[2]) > 0.3:
        w[TAU + i] -= p[0] * (math.sin(p[1] * w[Q + i] + p[2]) - 0.3) * math.tanh(w[V + i] / 1e-3)


@law(OUTSIDE, size="pump", places=(BOTH,), pump=(2e-3, 8.0))
def chiral_drag(i, t, dt, w, p, s):
    """The other joint's rate drives this one, the more the further this one is out: neither spring nor damper."""
    w[TAU + i] -= p[0] * w[V + 1 - i] * (w[Q + i] if i == 0 else -w[Q + i])


@law(OUTSIDE, size="torque", places=EACH, torque=(2e-4, 0.15), hertz=(7.0, 33.0), wobble=(0.1, 0.6))
def shaker(i, t, dt, w, p, s):
    """Something else on the bench shakes the leg, its pitch wandering."""
    w[TAU + i] += p[0] * math.sin(TURN * p[1] * 1e-3 * (t + 300.0 * p[2] * math.sin(TURN * t / 2900.0)))
