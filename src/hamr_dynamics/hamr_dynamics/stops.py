"""End stops: a spring and damper that act on one side only and never pull."""

from __future__ import annotations

from dataclasses import dataclass

from . import scalar


@dataclass(frozen=True, slots=True)
class Stop:
    """Force of a stop with the spring and damper that are active, and whether one is."""

    force: object
    stiffness: object
    damping: object
    active: object


def stop_force(x, rate, low, high, stiffness, damping) -> Stop:
    """Stops at low and high: force = -(k depth + d depth rate) where that pushes back, 0 elsewhere.

    Units as the coordinate's: mm, mm/ms, N/mm, N ms/mm or rad, rad/ms, N mm/rad, N mm ms/rad.
    """
    over, under = x - high, low - x
    above = scalar.maximum(stiffness * over + damping * rate, 0.0) * scalar.positive(over)
    below = scalar.maximum(stiffness * under - damping * rate, 0.0) * scalar.positive(under)
    active = scalar.positive(above + below)
    return Stop(below - above, active * stiffness, active * damping, active)
