"""A point foot on flat ground: unilateral spring-damper along the normal, regularised Coulomb friction, both implicit.

The step first solves with contact linearised about the present (`Contact`), then clamps each foot's force to what ground
can do: it never pulls, and friction stays in the cone. The clamped force is what moves the robot.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import scalar, vec


@dataclass(frozen=True, slots=True)
class Contact:
    """Force on the foot F = push - D v+, D = slip 1 + (grip - slip) n n^T, v+ the foot's velocity after the step.

    Attributes:
        normal: (3,) ground normal in base axes. push: spring force along it, N.
        grip, slip: resistance along and across the normal, N ms/mm; both 0 without contact.
        velocity: (3,) foot velocity before the step, mm/ms.
    """

    normal: tuple
    push: object
    grip: object
    slip: object
    velocity: tuple


def approach(height, velocity, normal, friction, h, *, stiffness, damping, slip_speed) -> Contact:
    """Linearised contact.

    Args:
        height: of the foot above ground half a step ahead, mm.
        velocity: (3,) foot velocity in base axes, mm/ms. normal: (3,) ground normal in base axes.
        friction: Coulomb coefficient. h: step, ms.
        stiffness: N/mm. damping: N ms/mm. slip_speed: mm/ms, below which friction is viscous.
    """
    rise = vec.dot(normal, velocity)
    depth = -height - (0.5 * h) * rise  # at the end of the step
    load = stiffness * depth - damping * rise
    touching = scalar.positive(depth) * scalar.positive(load)
    across = vec.sub(velocity, vec.scale(normal, rise))
    speed = scalar.sqrt(vec.dot(across, across) + slip_speed * slip_speed)
    slip = touching * (friction * scalar.maximum(load, 0.0)) / speed
    return Contact(normal, touching * (stiffness * -height), touching * (stiffness * (0.5 * h) + damping), slip, velocity)


def clamp(contact: Contact, velocity, friction):
    """Force that ground can give at foot velocity `velocity` after the step: no pull, inside the cone. N."""
    rise = vec.dot(contact.normal, velocity)
    load = scalar.maximum(contact.push - contact.grip * rise, 0.0)
    drag = vec.scale(vec.sub(velocity, vec.scale(contact.normal, rise)), -contact.slip)
    size = scalar.sqrt(vec.dot(drag, drag) + 1e-30)
    keep = scalar.minimum(friction * load / size, 1.0)
    return vec.add(vec.scale(drag, keep), vec.scale(contact.normal, load))
