"""The drive weakens or strengthens over the run."""

from __future__ import annotations

import math

from ..scalar import cos, sin
from .law import Effect, Form, Input, Parameter

WAVES = ("slow", "fast")


def linear(x: Input, p, z):
    """u (1 + rate t)."""
    return x.u + (p["rate"] * x.time) * x.u, z


def settling(x: Input, p, z):
    """u (1 + change (1 - exp(-t / time)))."""
    share = x.step / (p["time"] + 0.5 * x.step)
    done = z[0] + share * (1.0 - z[0])
    return x.u + (p["change"] * done) * x.u, (done,)


def waves(x: Input, p, z):
    """u (1 + two waves, each with a period of its own): a gain that comes and goes."""
    gain, turn = 1.0, x.time / p["period"]
    for name, turns in zip(WAVES, (turn, turn * p["ratio"]), strict=True):
        phase = 2.0 * math.pi * turns
        gain = gain + p[f"{name}_sine"] * sin(phase) + p[f"{name}_cosine"] * cos(phase)
    return x.u * gain, z


EFFECT = Effect(
    name="drive_drift",
    part="actuator",
    summary="A drive gain that changes slowly over the run.",
    forms=(
        Form("linear", "drive", linear, (Parameter("rate", "1/T", 1e-5, -1e-2, 1e-2, "relative change per time"),), order=8),
        Form(
            "settling",
            "drive",
            settling,
            (
                Parameter("change", "1", 0.05, -0.95, 3.0, "relative change in the end"),
                Parameter("time", "T", 500.0, 20.0, 1e6, "in which most of it happens", shape=True, screen=(100.0, 500.0, 2000.0)),
            ),
            states=1,
            order=8,
        ),
        Form(
            "waves",
            "drive",
            waves,
            (
                *(Parameter(f"{n}_{part}", "1", 0.03, -0.9, 0.9, f"of the {n} wave") for n in WAVES for part in ("sine", "cosine")),
                Parameter("period", "T", 2000.0, 100.0, 1e5, "of the slow wave", shape=True, screen=(1000.0, 2000.0, 4000.0)),
                Parameter("ratio", "1", 2.5, 1.2, 6.0, "of it to that of the fast wave", shape=True, screen=(1.5, 2.3, 3.0)),
            ),
            order=8,
        ),
    ),
    experiment="the same signal at the beginning and the end of a run",
    source="hamr_facts 7, effects 5 and 29 (ageing, temperature)",
)
