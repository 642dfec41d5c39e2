"""What acts on the robot as a whole on the ground: payload, slope, tether, surface; each law changes the numbers of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from hamr_description.numbers import value

from ..case import Effect
from ..laws.law import LAWS, Law

#: Effects of all hips and drives: these laws of one leg, on every leg alike.
OF_LEGS = ("coulomb_friction", "cubic_stiffness", "drive_lag", "drive_saturation", "drive_delay")
Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """Numbers of the robot's surroundings (g, mm, ms, N); as they stand here, nothing is hidden.

    Attributes:
        friction: coefficient of slow feet; loses the share `fall` of it at slips far above `slip` mm/ms.
        stiffness, damping: of the ground under one foot.
        gravity: vector.
        payload: mass, and where it sits in base_link.
        pull: constant force.
        coil, reach: force of a coil to where the robot started, far off; half of it at the distance `reach`.
        hook: where pull and coil act, in base_link.
        legs: effects of OF_LEGS.
    """

    friction: float = value("contact.friction")
    fall: float = 0.0
    slip: float = 1.0
    stiffness: float = value("contact.stiffness")
    damping: float = value("contact.damping")
    gravity: Vector = (0.0, 0.0, -value("robot.gravity"))
    payload: float = 0.0
    seat: Vector = ZERO
    pull: Vector = ZERO
    coil: float = 0.0
    reach: float = 1.0
    hook: Vector = ZERO
    legs: tuple[Effect, ...] = ()


@dataclass(frozen=True, slots=True)
class GroundLaw:
    """A formula for a family, as `laws.Law`: `apply` puts it with its parameters into a scene."""

    family: str
    name: str
    apply: Callable[[Scene, Mapping[str, float]], Scene]
    ranges: Mapping[str, tuple[float, float]]
    size: str


GROUND_LAWS: dict[str, GroundLaw] = {}


def scene(effects: tuple[Effect, ...]) -> Scene:
    """The scene with effects in it."""
    made = Scene(legs=tuple(effect for effect in effects if effect.law in LAWS))
    for effect in effects:
        if effect.law in GROUND_LAWS:
            made = GROUND_LAWS[effect.law].apply(made, effect.parameters)
    return made


def _law(family: str, *, size: str, **ranges: tuple[float, float]) -> Callable:
    def register(function: Callable) -> Callable:
        GROUND_LAWS[function.__name__] = GroundLaw(family, function.__name__, function, ranges, size)
        return function

    return register


def _around(angle: float, length: float) -> tuple[float, float]:
    return length * math.cos(angle), length * math.sin(angle)


@_law("ground_friction", size="change", change=(0.01, 0.95), side=(-1.0, 1.0))
def other_surface(scene, p):
    """Another coefficient: smaller, or for side > 0 larger."""
    return replace(scene, friction=scene.friction * (1.0 + math.copysign(p["change"], p["side"])))


@_law("ground_friction", size="fall", fall=(0.01, 0.95), slip=(0.01, 0.08))
def slippery_when_fast(scene, p):
    """The coefficient falls with the slip as 1 - fall (1 - exp(-v / slip))."""
    return replace(scene, fall=p["fall"], slip=p["slip"])


@_law("ground_compliance", size="softness", softness=(1.05, 400.0))
def soft_mat(scene, p):
    """So much softer, with the same damping ratio."""
    return replace(scene, stiffness=scene.stiffness / p["softness"], damping=scene.damping / math.sqrt(p["softness"]))


@_law("ground_compliance", size="softness", softness=(1.05, 400.0), loss=(1.5, 6.0))
def foam(scene, p):
    """Softer, and more damped than that."""
    return replace(scene, stiffness=scene.stiffness / p["softness"], damping=p["loss"] * scene.damping / math.sqrt(p["softness"]))


@_law("added_mass", size="mass", mass=(0.01, 4.0), forward=(-12.0, 12.0), left=(-4.0, 4.0), up=(2.0, 9.0))
def payload(scene, p):
    """A small heavy thing on the lid."""
    return replace(scene, payload=p["mass"], seat=(p["forward"], p["left"], p["up"]))


@_law("gravity_tilt", size="slope", slope=(0.002, 0.45), downhill=(-3.1, 3.1))
def slope(scene, p):
    """The ground slopes; downhill: direction in odom. `slope` in rad."""
    size = math.hypot(*scene.gravity)
    return replace(scene, gravity=(*_around(p["downhill"], size * math.sin(p["slope"])), -size * math.cos(p["slope"])))


@_law("tether_force", size="force", force=(5e-5, 2e-2), direction=(-3.1, 3.1), rise=(0.0, 1.2), forward=(-15.0, 0.0))
def hanging_wire(scene, p):
    """A constant force (N) on the back, `rise` rad above the ground."""
    flat = _around(p["direction"], p["force"] * math.cos(p["rise"]))
    return replace(scene, pull=(*flat, p["force"] * math.sin(p["rise"])), hook=(p["forward"], 0.0, 5.0))


@_law("tether_force", size="force", force=(5e-5, 2e-2), reach=(5.0, 60.0), forward=(-15.0, 0.0))
def coiled_wire(scene, p):
    """A coil to where the robot started, whose force levels off."""
    return replace(scene, coil=p["force"], reach=p["reach"], hook=(p["forward"], 0.0, 5.0))


def families() -> tuple[str, ...]:
    """Names of what can be hidden on the ground."""
    return tuple(sorted({law.family for law in GROUND_LAWS.values()} | set(OF_LEGS)))


def laws_of(family: str) -> tuple[GroundLaw | Law, ...]:
    """Laws of a family: GroundLaw, or Law where it acts in the legs."""
    return tuple(law for law in (*GROUND_LAWS.values(), *LAWS.values()) if law.family == family)
