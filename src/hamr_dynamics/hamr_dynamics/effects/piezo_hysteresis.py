"""The piezo remembers where its voltage turned round."""

from __future__ import annotations

from ..scalar import clip
from .dragged import dragged
from .law import Effect, Form, Input, Parameter

WIDTH = Parameter("width", "U", 0.5, 0.02, 5.0, "voltage over which a turn is forgotten", shape=True, screen=(0.2, 0.6, 1.5))
RADII = (0.25, 0.5, 1.0, 2.0)


def bouc_wen(x: Input, p, z):
    """u - size h, dh = du - |du| h / width (Bouc-Wen with beta = 1/width, gamma = 0)."""
    h, before = z
    new, _ = dragged(h, x.u - before, 1.0, p["width"])
    return x.u - p["size"] * new, (new, x.u)


def plays(x: Input, p, z):
    """u - sum of weights times (u - play of u), four plays with radii a quarter to twice the width (Prandtl-Ishlinskii)."""
    y, new = x.u, []
    for i, (radius, play) in enumerate(zip(RADII, z, strict=True)):
        r = radius * p["width"]
        moved = clip(play, x.u - r, x.u + r)
        new.append(moved)
        y = y - p[f"weight{i + 1}"] * (x.u - moved)
    return y, tuple(new)


EFFECT = Effect(
    name="piezo_hysteresis",
    part="actuator",
    summary="A loop between voltage and force that does not depend on how fast it is run through.",
    forms=(
        Form("bouc_wen", "drive", bouc_wen, (Parameter("size", "1", 0.1, 0.0, 2.0, "of the loop"), WIDTH), states=2, order=6),
        Form("plays", "drive", plays, (
            *(Parameter(f"weight{i + 1}", "1", 0.03, -0.5, 1.0, f"of the play of radius {r:g} widths") for i, r in enumerate(RADII)),
            Parameter("width", "U", 0.8, 0.02, 5.0, "unit of the radii", shape=True, screen=(0.8,)),
        ), states=4, order=6),
    ),
    experiment="slow triangles of two amplitudes, with minor loops",
    source="hamr_facts 7, effect 11; Bouc 1967, Wen 1976; Kuhnen 2003 (Prandtl-Ishlinskii)",
    mimics=("spring_hysteresis",),  # far below the resonance, where a drive is a force
)  # fmt: skip
