"""Dry friction that is larger near standstill than while sliding fast."""

from __future__ import annotations

from .coulomb_friction import DISTANCE, LEVEL, SHARE, SHARPNESS, TIME, WIDTH, bristles, sliding, under_load
from .law import Effect, Form, Joint, Parameter

LITTLE = 1e-12  # of a force


def bell(ratio):
    """1 at standstill, a half at the speed, 0 far beyond."""
    return 1.0 / (1.0 + ratio * ratio)


def lorentzian(x: Joint, p, z):
    """-(level + excess / (1 + (v/speed)^2)) sign(v)."""
    return sliding(x, p["width"], p["level"] + p["excess"] * bell(x.v / p["speed"])), z


def loaded(x: Joint, p, z):
    """-(level + share |drive|) (1 + boost / (1 + (v/speed)^2)) sign(v): as of coulomb_friction, and larger near standstill."""
    return sliding(x, p["width"], under_load(x, p) * (1.0 + p["boost"] * bell(x.v / p["speed"]))), z


def lugre(x: Joint, p, z):
    """As of coulomb_friction, -(level + excess) (z + time dz/dt), whose limit falls from 1 with the rate r, in speeds: by
    (1 - tail) exp(-r^2) + tail / (1 + r^2)."""
    ratio = x.v / p["speed"]
    core = 1.0 / (1.0 + 0.25 * ratio * ratio)
    core = core * core
    left = core * core + p["tail"] * (bell(ratio) - core * core)  # (1 + r^2 / 4)^-4 is exp(-r^2) within 0.07
    breakaway = p["level"] + p["excess"]
    limit = (p["level"] + p["excess"] * left + LITTLE) / (breakaway + LITTLE)  # where all sizes are zero it is 1
    return bristles(x, p, z, breakaway=breakaway, limit=limit)


EXCESS = Parameter("excess", "F", 0.05, 0.0, 10.0, "how much larger it is near standstill")
BOOST = Parameter("boost", "1", 0.5, 0.0, 5.0, "share by which it is larger near standstill", shape=True)
TAIL = Parameter("tail", "1", 0.3, 0.0, 1.0, "share of the excess that falls slowly", shape=True)
SPEED = Parameter("speed", "Q/T", 0.3, 0.01, 5.0, "rate at which half the excess is left", shape=True, screen=(0.1, 0.4))

EFFECT = Effect(
    name="stribeck_friction",
    part="transmission",
    summary="Dry friction of a joint that falls from a larger value near standstill to a smaller one with speed.",
    forms=(
        Form("lorentzian", "force", lorentzian, (LEVEL, EXCESS, SPEED, WIDTH)),
        Form("loaded", "force", loaded, (LEVEL, SHARE, BOOST, SPEED, WIDTH)),
        Form("lugre", "force", lugre, (LEVEL, EXCESS, SPEED, TAIL, TIME, DISTANCE, SHARPNESS), states=2),
    ),  # fmt: skip
    experiment="slow breakaway ramps and constant speeds",
    source="Stribeck 1902; LuGre: Canudas de Wit et al. 1995; Olsson et al. 1998, Friction models and friction compensation",
    contains=("coulomb_friction",),
)
