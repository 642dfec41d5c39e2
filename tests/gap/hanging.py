"""An arm that hangs from a shaft with viscous friction, as a model without any effect."""

from __future__ import annotations

from hamr_dynamics.machine import Machine, Terms
from hamr_dynamics.scalar import cos, sin


def hanging(name: str, *, inertia: float, weight: float, damping: float) -> Machine:
    """kg m^2, N m at a right angle, N m s; its joint is "arm", and N m drive it."""

    def terms(q, v_mid, v, u) -> Terms:
        force = u[0] - weight * sin(q[0]) - damping * v[0]
        return Terms((inertia,), (0.0,), (force,), (weight * cos(q[0]),), (damping,), (u[0],))

    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "N*m"}
    return Machine(name, ("arm",), ("arm",), terms, lambda q, slip: (q[0],), units, dict.fromkeys("FQTU", 1.0))
