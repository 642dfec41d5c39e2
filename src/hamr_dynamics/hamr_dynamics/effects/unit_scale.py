"""One leg is the same machine in another size."""

from __future__ import annotations

from dataclasses import replace

from .law import Effect, Form, Parameter


def common(x, p, z):
    """Drive, springs, dampers and masses of a leg, all times (1 + change)."""
    by = 1.0 + p["change"]

    def scaled(values) -> tuple:
        return tuple(by * value for value in values)

    bodies = [replace(body, mass=by * body.mass, inertia=scaled(body.inertia)) for body in x.bodies]
    names = ("force", "stiffness", "damping", "tip_force", "torque")
    return replace(x, bodies=bodies, **{name: scaled(getattr(x, name)) for name in names}), z


EFFECT = Effect(
    name="unit_scale",
    part="body",
    summary="A leg whose force, stiffness, damping and mass are all larger or smaller by one factor, as another build or unit has it.",
    forms=(Form("common", "leg", common, (Parameter("change", "1", 0.1, -0.9, 3.0, "relative change"),)),),
    experiment="on the ground, or with a known mass on the leg: in the air no voltage shows it",
    source="gap_method 0 (6), 3.2 (leg-specific scale)",
    same_as={"no effect at all": "suspended: drive, stiffness, damping and inertia scale together"},
    needs=("ground",),
)
