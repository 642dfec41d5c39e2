"""Laws that no library names: things on the bench and in the leg that grip, fire, charge and let go."""

from __future__ import annotations

import math

from .law import ANY, BOTH, TAU, Q, U, V, law
from .outside import OUTSIDE


@law(OUTSIDE, size="force", places=(BOTH,), force=(5e-4, 0.3), edge=(-0.1, 0.03), swing=(-1.0, 1.0), lift=(-1.0, 1.0))
def felt_corner(i, t, dt, w, p, s):
    """Felt in one corner of the leg's reach rubs the tip where both joints are beyond `edge`, against the way it goes across."""
    deep = min(math.copysign(1.0, p[2]) * w[Q], math.copysign(1.0, p[3]) * w[Q + 1]) - p[1]
    if deep > 0.0:
        w[TAU + i] -= p[0] * min(deep / 0.1, 1.0) * w[V + i] / math.sqrt(w[V] ** 2 + w[V + 1] ** 2 + 1e-6)


@law(OUTSIDE, size="loss", places=ANY, states=1, loss=(0.01, 0.95), coercive=(8.0, 25.0), tau=(12.0, 40.0))
def depoling(i, t, dt, w, p, s):
    """A field against the poling, beyond `coercive`, takes gain away bit by bit; one along it brings it back; between, it stays."""
    over = min(max(abs(w[U + i]) / p[1] - 1.0, 0.0), 1.0)
    goal = 1.0 if w[U + i] < 0.0 else 0.0
    s[0] += (goal - s[0]) * -math.expm1(-over * dt / p[2])
    w[U + i] *= 1.0 - p[0] * s[0]


@law(OUTSIDE, size="torque", states=1, torque=(5e-4, 0.4), way=(0.5, 4.0))
def static_charge(i, t, dt, w, p, s):
    """Rubbing charges the leg, a plate pulls it by the charge squared, and after every `way` travelled it sparks and is bare."""
    s[0] += abs(w[V + i]) * dt / p[1]
    if s[0] > 1.0:
        s[0] = 0.0
    w[TAU + i] += p[0] * s[0] * s[0]


@law(OUTSIDE, size="flux", places=(BOTH,), states=1, flux=(0.1, 400.0), tau=(0.3, 1.2))
def shorted_coil(i, t, dt, w, p, s):
    """A shorted coil whose flux is swing times lift: the current, which dies in `tau`, brakes both; s holds the flux it has got used to."""
    flux = w[Q] * w[Q + 1]
    old = s[0]
    s[0] += -math.expm1(-dt / p[1]) * (flux - old)
    w[TAU + i] -= p[0] * (flux - 0.5 * (old + s[0])) * w[Q + 1 - i]


@law(OUTSIDE, size="stiffness", states=1, stiffness=(0.02, 20.0), home=(-0.15, 0.0), push=(0.7, 2.5), back=(100.0, 800.0), side=(-1.0, 1.0))
def sand_heap(i, t, dt, w, p, s):
    """A heap in the way: it gives where the leg leans on it, stays pushed, and trickles back; s holds how far it is from home."""
    side = math.copysign(1.0, p[4])
    deep = max(side * w[Q + i] - p[1] - s[0], 0.0)
    s[0] += dt * (deep / p[2] - s[0] / p[3])
    w[TAU + i] -= side * p[0] * deep


@law(OUTSIDE, size="torque", states=1, torque=(1e-3, 0.2), leak=(15.0, 80.0), side=(-1.0, 1.0))
def foot_pump(i, t, dt, w, p, s):
    """The other joint, on its way to one side, pumps air under this one; s holds the pressure, which leaks."""
    s[0] += dt * (max(math.copysign(1.0, p[2]) * w[V + 1 - i], 0.0) - s[0] / p[1])
    w[TAU + i] += p[0] * min(s[0], 4.0)


@law(OUTSIDE, size="torque", states=2, torque=(5e-4, 0.5), place=(-0.1, 0.1), blow=(3.0, 12.0), rest=(10.0, 60.0))
def kicker(i, t, dt, w, p, s):
    """A bumper that, touched from below `place`, hits back for `blow` ms and is deaf for `rest`; s: time left, last angle."""
    if s[0] <= 0.0 and s[1] < 0.0 and w[Q + i] >= p[1]:
        s[0] = p[2] + p[3]
    s[1] = w[Q + i] - p[1]
    if s[0] > 0.0:
        if s[0] > p[3]:
            w[TAU + i] -= p[0]
        s[0] -= dt


@law(OUTSIDE, size="stiffness", states=2, stiffness=(2e-3, 1.5), level=(15.0, 45.0))
def electric_clamp(i, t, dt, w, p, s):
    """A pad that clings while the other channel's voltage is beyond `level`, elastic about where it took hold; s: if it does, and where."""
    if abs(w[U + 1 - i]) <= p[1]:
        s[0] = 0.0
    else:
        if s[0] == 0.0:
            s[0], s[1] = 1.0, w[Q + i]
        w[TAU + i] -= p[0] * (w[Q + i] - s[1])
