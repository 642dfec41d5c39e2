"""Friction by bristles and the other losses that depend on rate: torques on the leg."""

from __future__ import annotations

import math

from .law import ANY, EACH, TAU, Q, V, law

STIFF = 0.01  # ms


@law("coulomb_friction", size="force", places=ANY, states=1, step=STIFF, force=(2e-4, 0.3), presliding=(3e-4, 4e-3), damping=(0.1, 0.8))
def lugre(i, t, dt, w, p, s):
    """LuGre's bristle without a Stribeck curve; deflection solved exactly over the step, damping as a share of the critical one."""
    v, stiffness = w[V + i], p[0] / p[1]
    goal = math.copysign(p[1], v)
    new = goal + (s[0] - goal) * math.exp(-abs(v) * dt / p[1])
    w[TAU + i] -= stiffness * 0.5 * (s[0] + new) + 2.0 * p[2] * math.sqrt(stiffness) * (new - s[0]) / dt
    s[0] = new


@law("coulomb_friction", size="force", places=ANY, states=1, step=STIFF, force=(2e-4, 0.3), presliding=(3e-4, 4e-3), yielding=(0.3, 0.8))
def elasto_plastic(i, t, dt, w, p, s):
    """Dupont's bristle: elastic up to a share `yielding` of its limit, so that it does not drift below."""
    v, z, low = w[V + i], s[0], p[1] * p[2]
    slip = 0.0
    if v * z > 0.0 and abs(z) > low:
        slip = 0.5 + 0.5 * math.sin(math.pi * (min(abs(z), p[1]) - 0.5 * (p[1] + low)) / (p[1] - low))
    new = z + dt * v * (1.0 - slip * abs(z) / p[1])
    s[0] = min(max(new, -p[1]), p[1])
    w[TAU + i] -= p[0] / p[1] * 0.5 * (z + s[0]) + 0.3 * math.sqrt(p[0] / p[1]) * (s[0] - z) / dt


@law("stribeck_friction", size="force", places=ANY, states=1, step=STIFF, force=(2e-4, 0.2), excess=(0.4, 2.5), rate=(1.5e-3, 1.5e-2),
     power=(0.6, 2.0), presliding=(3e-4, 3e-3))  # fmt: skip
def lugre_stribeck(i, t, dt, w, p, s):
    """LuGre: the bristle's limit falls from force (1 + excess) to force with the rate."""
    v, stiffness = w[V + i], p[0] / p[4]
    limit = p[4] * (1.0 + p[1] * math.exp(-((abs(v) / p[2]) ** p[3])))
    goal = math.copysign(limit, v)
    new = goal + (s[0] - goal) * math.exp(-abs(v) * dt / limit)
    w[TAU + i] -= stiffness * 0.5 * (s[0] + new) + 0.6 * math.sqrt(stiffness) * (new - s[0]) / dt
    s[0] = new


@law("stribeck_friction", size="force", places=ANY, states=1, step=STIFF, force=(2e-4, 0.2), excess=(0.4, 2.5), rate=(1.5e-3, 1.5e-2),
     presliding=(3e-4, 3e-3))  # fmt: skip
def rational_stribeck(i, t, dt, w, p, s):
    """An element that sticks as a spring and slips at a limit which falls as 1 / (1 + (v / rate)^2)."""
    v, stiffness = w[V + i], p[0] / p[3]
    limit = p[3] * (1.0 + p[1] / (1.0 + (v / p[2]) ** 2))
    old = s[0]
    s[0] = min(max(old + dt * v, -limit), limit)
    w[TAU + i] -= stiffness * 0.5 * (s[0] + old) + 0.3 * math.sqrt(stiffness) * (s[0] - old) / dt


@law("quadratic_damping", size="drag", places=ANY, drag=(0.02, 300.0), core=(3e-4, 4e-3))
def smooth_square(i, t, dt, w, p, s):
    """v sqrt(v^2 + core^2): viscous below the core rate, quadratic above."""
    v = w[V + i]
    w[TAU + i] -= p[0] * v * math.sqrt(v * v + p[1] * p[1])


@law("quadratic_damping", size="drag", places=ANY, drag=(0.02, 300.0), core=(5e-4, 5e-3))
def turbulent(i, t, dt, w, p, s):
    """v^2 with the sign of the flow, which turns over within the core rate."""
    v = w[V + i]
    w[TAU + i] -= p[0] * v * v * math.tanh(v / p[1])


@law("configuration_dependent_damping", size="damping", places=EACH, damping=(1e-3, 4.0), width=(0.08, 0.3))
def bowl(i, t, dt, w, p, s):
    """Damping that grows to both sides as cosh - 1."""
    w[TAU + i] -= p[0] * (math.cosh(min(abs(w[Q + i]) / p[1], 12.0)) - 1.0) * w[V + i]


@law("configuration_dependent_damping", size="damping", places=EACH, damping=(1e-3, 1.0), gap=(0.6, 1.3), side=(-1.0, 1.0))
def squeeze_film(i, t, dt, w, p, s):
    """A film thinning towards one side: 1 / gap^3, its value at rest apart."""
    height = max(1.0 - math.copysign(1.0, p[2]) * w[Q + i] / p[1], 0.1)
    w[TAU + i] -= p[0] * (height**-3 - 1.0) * w[V + i] if height < 1.0 else p[0] * 0.3 * (height**-3 - 1.0) * w[V + i]
