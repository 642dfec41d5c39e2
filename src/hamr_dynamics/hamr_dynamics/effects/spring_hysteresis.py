"""A joint's spring remembers where its motion turned round: flexures with glue, belts, wire ropes."""

from __future__ import annotations

from ..scalar import LITTLE, clip, maximum, minimum, positive, sqrt
from .law import Effect, Form, Joint, Parameter, Push

YIELDS = (0.25, 0.5, 1.0, 2.0)  # of sliders, in widths


def bouc_wen(x: Joint, p, z):
    """-size z, dz/dt = (v - |v| z - skew v |z|) / distance (Bouc-Wen of exponent one, whose alpha, beta gamma and delta / gamma are
    size / distance, 1 / distance and skew)."""
    ahead = x.step * x.v / p["distance"]
    far, twist = maximum(ahead, -ahead), maximum(z[0], -z[0])
    back, out = 1.0 - p["skew"], 1.0 + p["skew"]  # what it yields by until there is no twist, and beyond
    home = minimum(far, positive(-ahead * z[0]) * twist / (1.0 + 0.5 * back * twist))
    rest = far - home
    before, after = back * home, out * rest
    passed = before + after
    keep = 1.0 / (1.0 + passed + 0.5 * passed * passed)  # exp(-passed), as in `dragged`, which knows one limit only
    way = ahead / (far + LITTLE)
    new = keep * (z[0] + way * (home * (1.0 + 0.5 * before) + rest * (1.0 + before + 0.5 * after)))
    slope = (1.0 + passed) * keep * (1.0 - way * new * (back + (out - back) * positive(rest)))
    return Push(-(p["size"] * new), stiffness=p["size"] / p["distance"] * maximum(slope, 0.0)), (new,)


def squared(x: Joint, p, z):
    """-size z, dz/dt = (v - |v| |z| z - skew v z^2) / distance: the same of exponent two, which bends later and then faster."""
    ahead = x.step * x.v / p["distance"]
    loading = positive(ahead * z[0])
    bend = loading * (1.0 + p["skew"]) - (1.0 - loading) * (1.0 - p["skew"])  # dz = (1 - bend z^2) along the way
    near = ahead / sqrt(1.0 + loading * bend * ahead * ahead)  # no further than the limit
    new = (z[0] + near) / (1.0 + bend * near * z[0])  # tanh or tan of a sum
    return Push(-(p["size"] * new), stiffness=p["size"] / p["distance"] * maximum(1.0 - bend * new * new, 0.0)), (new,)


def sliders(x: Joint, p, z):
    """Springs in series with dry sliders, four that yield at twists of a quarter to twice the width (Maxwell slip, Iwan)."""
    force, stiffness, new = 0.0, 0.0, []
    for i, (share, twist) in enumerate(zip(YIELDS, z, strict=True)):
        limit, free = share * p["width"], twist + x.step * x.v
        held = clip(free, -limit, limit)
        new.append(held)
        k = p[f"stiffness{i + 1}"]
        force = force - k * held
        stiffness = stiffness + k * (1.0 - positive(maximum(free, -free) - limit))
    return Push(force, stiffness=maximum(stiffness, 0.0)), tuple(new)


SIZE = Parameter("size", "F", 0.3, 0.0, 100.0, "force at which the loop has bent")
DISTANCE = Parameter("distance", "Q", 1.0, 0.02, 20.0, "way over which a turn is forgotten", shape=True, screen=(0.5, 2.0))


def _skew(low: float, *screen: float) -> Parameter:
    return Parameter("skew", "1", 0.0, low, 1.0, "by how much more it yields on the way out than back", shape=True, screen=screen)


EFFECT = Effect(
    name="spring_hysteresis",
    part="transmission",
    summary="A loop between angle and force of a joint's spring that does not depend on how fast it is run through.",
    forms=(
        Form("bouc_wen", "force", bouc_wen, (SIZE, DISTANCE, _skew(-3.0, -1.2, 0.0, 0.9)), states=1),
        Form("squared", "force", squared, (SIZE, DISTANCE, _skew(-0.9, -0.6, 0.5)), states=1),
        Form("sliders", "force", sliders, (
            *(Parameter(f"stiffness{i + 1}", "F/Q", 0.05, -1.0, 10.0, f"that yields at {y:g} widths") for i, y in enumerate(YIELDS)),
            Parameter("width", "Q", 0.8, 0.02, 10.0, "unit of the twists", shape=True, screen=(0.8,)),
        ), states=4),
    ),
    experiment="slow triangles of two amplitudes, with minor loops",
    source="Bouc 1967, Wen 1976; Iwan 1966; benchmark of hysteresis: Noel and Schoukens 2016",
    contains=("coulomb_friction",),  # without skew, and a short way
    mimics=("piezo_hysteresis",),  # far below the resonance
)  # fmt: skip
