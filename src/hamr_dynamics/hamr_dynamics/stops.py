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


def stop_force(x, rate, low, high, stiffness, damping, step=None) -> Stop:
    """Stops at low and high: force = -(k depth + d depth rate) where that pushes back, 0 elsewhere.

    With a step, the mean force over a step with x in its middle, which may touch for a part of it only (`touching`).
    Units as the coordinate's: mm, mm/ms, N/mm, N ms/mm or rad, rad/ms, N mm/rad, N mm ms/rad; step in ms.
    """
    over, under = x - high, low - x
    if step is None:
        up, down = scalar.positive(over), scalar.positive(under)
    else:
        (up, over), (down, under) = touching(over, rate, step), touching(under, rate, step)
    above = scalar.maximum(stiffness * over + damping * rate, 0.0) * up
    below = scalar.maximum(stiffness * under - damping * rate, 0.0) * down
    active = scalar.positive(above + below)
    share = active * scalar.maximum(up, down)
    return Stop(below - above, share * stiffness, share * damping, active)


def touching(depth, rate, step) -> tuple:
    """Share of a step in which a stop is touched, and the mean depth while it is; `depth` is that in the middle of the step.

    So nothing jumps with the step in which something hits, which derivatives of a fit would stumble over.
    """
    half = 0.5 * step * scalar.maximum(rate, -rate)
    share = scalar.clip(0.5 + 0.5 * depth / (half + scalar.LITTLE), 0.0, 1.0)
    return share, depth + half * (1.0 - share)
