"""The step of a plant under a drive: which stages follow each other."""

from __future__ import annotations

from . import leg_stages
from .chassis_stages import balance_free, balance_soft, predict
from .emit import Part
from .plant import Plant
from .walking_leg_stages import finish_legs, grounded, reach


def step_parts(plant: Plant, environment: str, h: float) -> list[tuple[Part, int]]:
    """The step under a drive, in order: parts, and the lanes that each has of a robot."""
    found = [(part, 4) for part in leg_stages.forces(plant, h)]
    if environment == "suspended":
        return [*found, (Part(leg_stages.suspended(plant, h)), 4)]
    first, effects = predict(h, effects=plant.effects), plant.effects
    rest = [(reach(plant, h), 4), (balance_soft(h, effects=effects), 1), (grounded(plant, h), 4), (balance_free(h, effects=effects), 1),
            (finish_legs(h), 4)]  # fmt: skip
    return [(Part(first), 1), *found, *((Part(stage), lanes) for stage, lanes in rest)]
