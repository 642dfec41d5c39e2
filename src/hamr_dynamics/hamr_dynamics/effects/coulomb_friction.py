"""Dry friction of a joint: a force against the motion, however fast that is."""

from __future__ import annotations

from ..scalar import LITTLE, clip, maximum, sqrt
from .dragged import dragged
from .law import Effect, Form, Joint, Parameter, Push

LEVEL = Parameter("level", "F", 0.05, 0.0, 10.0, "friction force while sliding")
TIME = Parameter("time", "T", 0.02, 0.0, 10.0, "damping of the bristles over their stiffness; it acts while they yield", shape=True)
SHARE = Parameter("share", "1", 0.05, 0.0, 1.0, "of the drive's force, by which it grows")
SKEW = Parameter("skew", "1", 0.0, -1.0, 1.0, "share by which it is more while the coordinate grows, and less while it falls", shape=True,
                 screen=(0.0,))  # fmt: skip
WIDTH = Parameter("width", "Q/T", 0.02, 1e-4, 0.3, "rate at which the force has reached 0.7 of its level", shape=True, screen=(0.02,))
DISTANCE = Parameter("distance", "Q", 0.03, 1e-4, 1.0, "way over which bristles yield before sliding", shape=True, screen=(0.01, 0.1))
SHARPNESS = Parameter("sharpness", "1", 0.5, 0.0, 1.0, "share of the bristles that yield all at once", shape=True)


def gliding(v, width):
    """Sign of a rate, smooth within `width`, and its slope."""
    size = sqrt(v * v + width * width)
    return v / size, width * width / (size * size * size)


def sliding(x: Joint, width, size) -> Push:
    """-size sign(v), of a size that does not depend on the rate, or changes slowly with it."""
    direction, slope = gliding(x.v, width)
    return Push(-(size * direction), damping=size * slope)


def under_load(x: Joint, p):
    """Size of a friction that grows with the force of the drive: teeth and screws press harder on each other the more they bear."""
    return p["level"] + p["share"] * maximum(x.drive, -x.drive)


def sign(x: Joint, p, z):
    """-level sign(v)."""
    return sliding(x, p["width"], p["level"]), z


def asymmetric(x: Joint, p, z):
    """-level (1 + skew) sign(v) while the coordinate grows, -level (1 - skew) sign(v) while it falls."""
    direction, slope = gliding(x.v, p["width"])
    skewed = p["level"] * p["skew"] * direction
    size = p["level"] + skewed
    return Push(-(size * direction), damping=(size + skewed) * slope), z


def loaded(x: Joint, p, z):
    """-(level + share |drive|) sign(v)."""
    return sliding(x, p["width"], under_load(x, p)), z


def presliding(x: Joint, p, z):
    """Dahl: -level z, dz/dt = (v - |v| z) / distance; elastic before it slides."""
    new, _ = dragged(z[0], x.step * x.v, p["distance"])
    yielding = maximum(1.0 - maximum(new, -new), 0.0)
    return Push(-(p["level"] * new), stiffness=p["level"] * yielding / p["distance"]), (new,)


def bristles(x: Joint, p, z, *, breakaway, limit):
    """Bristles that bear z, yield over a distance and slide at a limit: a share `sharpness` all at once, the others as in LuGre,
    dz/dt = (v - |v| z / limit) / distance.

    Args:
        breakaway: force of z = 1. limit: (0, 1], of z at this rate.
    """
    way, sharp = x.step * x.v, p["sharpness"]
    soft, softly = dragged(z[0], way, p["distance"], limit)
    ahead = way / p["distance"]
    free = z[1] + ahead
    hard = clip(free, -limit, limit)
    held = 1.0 - clip((maximum(free, -free) - limit) / (maximum(ahead, -ahead) + LITTLE), 0.0, 1.0)  # on that share of the way
    yielding = (1.0 - sharp) * maximum(1.0 - maximum(soft, -soft) / limit, 0.0) + sharp * held
    bending = (1.0 - sharp) * softly * p["distance"] + sharp * held  # share of a further rate that bends them
    bears, bore = (1.0 - sharp) * soft + sharp * hard, (1.0 - sharp) * z[0] + sharp * z[1]
    stiffness = breakaway / p["distance"]
    force = breakaway * (bears + p["time"] * (bears - bore) / x.step)
    return Push(-force, stiffness=stiffness * yielding, damping=stiffness * p["time"] * bending), (soft, hard)


def lugre(x: Joint, p, z):
    """-level (z + time dz/dt) of bristles that yield over a distance: gradually (LuGre) to all at once (Prandtl)."""
    return bristles(x, p, z, breakaway=p["level"], limit=1.0)


EFFECT = Effect(
    name="coulomb_friction",
    part="transmission",
    summary="A friction force against the motion of a joint that does not depend on how fast it is.",
    forms=(
        Form("sign", "force", sign, (LEVEL, WIDTH)),
        Form("presliding", "force", presliding, (LEVEL, DISTANCE), states=1),
        Form("lugre", "force", lugre, (LEVEL, TIME, DISTANCE, SHARPNESS), states=2),
        Form("asymmetric", "force", asymmetric, (LEVEL, SKEW, WIDTH)),
        Form("loaded", "force", loaded, (LEVEL, SHARE, WIDTH)),
    ),  # fmt: skip
    experiment="small slow reversals beside large fast ones: the equivalent damping falls as one over the amplitude",
    source="Coulomb 1785; presliding: Dahl 1968; LuGre: Canudas de Wit et al. 1995; robot joints: Janot, Gautier, Brunot 2019 (EMPS); "
    "with the load: Duclusaud, Passault et al. 2024, Extended friction models for the physics simulation of servo actuators",
)
