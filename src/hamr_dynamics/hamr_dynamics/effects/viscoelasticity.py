"""A spring that relaxes: the standard linear solid."""

from __future__ import annotations

from .law import Effect, Form, Joint, Parameter, Push


def relaxing(x: Joint, stiffness, time, before):
    """A spring and damper in series: its push and where its damper has moved to."""
    share = time / (time + x.step)
    moved = before * share + x.q * (1.0 - share)
    return -(stiffness * (x.q - moved)), stiffness * share, moved


def maxwell(x: Joint, p, z):
    """-k (q - z), dz/dt = (q - z) / time."""
    force, stiffness, moved = relaxing(x, p["stiffness"], p["time"], z[0])
    return Push(force, stiffness=stiffness), (moved,)


def two(x: Joint, p, z):
    """Two such elements, a fast and a slow one: a Prony series of two terms."""
    force, stiffness, fast = relaxing(x, p["fast"], p["short"], z[0])
    more, stiffer, slow = relaxing(x, p["slow"], p["long"], z[1])
    return Push(force + more, stiffness=stiffness + stiffer), (fast, slow)


EFFECT = Effect(
    name="viscoelasticity",
    part="transmission",
    summary="A part of a joint's spring that relaxes with one time of its own, or two.",
    forms=(Form("maxwell", "force", maxwell, (
        Parameter("stiffness", "F/Q", 0.05, 0.0, 10.0, "stiffness that relaxes"),
        Parameter("time", "T", 3.0, 0.02, 3000.0, "relaxation time", shape=True, screen=(0.3, 3.0, 30.0, 300.0)),
    ), states=1), Form("two", "force", two, (
        Parameter("fast", "F/Q", 0.05, 0.0, 10.0, "stiffness that relaxes first"),
        Parameter("slow", "F/Q", 0.05, 0.0, 10.0, "stiffness that relaxes later"),
        Parameter("short", "T", 1.0, 0.02, 30.0, "relaxation time of the first", shape=True, screen=(0.3, 1.0)),
        Parameter("long", "T", 60.0, 3.0, 3000.0, "of the second", shape=True, screen=(20.0, 100.0)),
    ), states=2)),
    experiment="holds of several relaxation times beside fast motion",
    source="hamr_facts 7, effect 23 (polyimide relaxation); Maxwell elements",
    mimics=("piezo_creep", "structural_damping"),
)  # fmt: skip
