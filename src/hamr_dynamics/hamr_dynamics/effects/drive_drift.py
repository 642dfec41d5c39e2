"""The drive weakens or strengthens over the run, by itself or as its own work warms it."""

from __future__ import annotations

import math

from ..scalar import cos, maximum, sin
from .law import Effect, Form, Input, Parameter

#: Turns of the two waves in a run to screen with: a wave between two of them is a quarter of a turn off at the ends, and not lost.
TURNS = {"slow": (2.5, 2.0, 1.5, 1.0, 0.6, 0.3), "fast": tuple(0.5 * k for k in range(30, 1, -1))}


def linear(x: Input, p, z):
    """u (1 + rate t)."""
    return x.u + (p["rate"] * x.time) * x.u, z


def settling(x: Input, p, z):
    """u (1 + change (1 - exp(-t / time)))."""
    done = _nearer(z[0], 1.0, x.step, p["time"])
    return x.u + (p["change"] * done) * x.u, (done,)


def heating(x: Input, p, z):
    """u (1 + change h), or u / (1 - change h) where it falls, h the mean of u^2 over the time before: what the piezo loses warms it."""
    heat = _nearer(z[0], x.u * x.u, x.step, p["time"])
    change = p["change"] * heat
    return x.u * (1.0 + maximum(change, 0.0)) / (1.0 + maximum(-change, 0.0)), (heat,)


def waves(x: Input, p, z):
    """u (1 + two waves, each with a period of its own): a gain that comes and goes."""
    gain = 1.0
    for name in TURNS:
        phase = 2.0 * math.pi * x.time / p[f"{name}_period"]
        gain = gain + p[f"{name}_sine"] * sin(phase) + p[f"{name}_cosine"] * cos(phase)
    return x.u * gain, z


def _nearer(z, goal, step, time):
    """A state after a step of its exponential way to a goal."""
    return z + step / (time + 0.5 * step) * (goal - z)


RATE = Parameter("rate", "1/S", 0.05, -5.0, 5.0, "relative change per time")
SETTLING = (
    Parameter("change", "1", 0.05, -0.95, 3.0, "relative change in the end"),
    Parameter("time", "S", 0.1, 0.005, 100.0, "in which most of it happens", shape=True, screen=(0.02, 0.1, 0.5)),
)
HEATING = (
    Parameter("change", "1/U^2", 0.05, -3.0, 3.0, "relative change per mean squared drive"),
    Parameter("time", "S", 0.05, 0.005, 10.0, "over which the mean is taken", shape=True, screen=(0.02, 0.05, 0.12)),
)
WAVES = (
    *(Parameter(f"{name}_{part}", "1", 0.03, -0.9, 0.9, f"of the {name} wave", by=(f"{name}_period",))
      for name in TURNS for part in ("sine", "cosine")),
    *(Parameter(f"{name}_period", "S", typical, 0.02, 20.0, f"of the {name} wave", shape=True, screen=tuple(1.0 / x for x in TURNS[name]))
      for name, typical in (("slow", 1.0), ("fast", 0.25))),
)  # fmt: skip

EFFECT = Effect(
    name="drive_drift",
    part="actuator",
    summary="A drive gain that changes slowly over the run.",
    forms=(
        Form("linear", "drive", linear, (RATE,), order=8),
        Form("settling", "drive", settling, SETTLING, states=1, order=8),
        Form("heating", "drive", heating, HEATING, states=1, order=8),
        Form("waves", "drive", waves, WAVES, order=8),
    ),
    experiment="the same signal at the beginning and the end of a run",
    source="hamr_facts 7, effects 5 and 29 (ageing, temperature)",
)
