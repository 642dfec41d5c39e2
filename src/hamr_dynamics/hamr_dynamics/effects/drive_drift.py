"""The drive weakens or strengthens over the run."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter


def linear(x: Input, p, z):
    """u (1 + rate t)."""
    return x.u + (p["rate"] * x.time) * x.u, z


def settling(x: Input, p, z):
    """u (1 + change (1 - exp(-t / time)))."""
    share = x.step / (p["time"] + 0.5 * x.step)
    done = z[0] + share * (1.0 - z[0])
    return x.u + (p["change"] * done) * x.u, (done,)


EFFECT = Effect(
    name="drive_drift",
    part="actuator",
    summary="A drive gain that changes steadily over the run.",
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
    ),
    experiment="the same signal at the beginning and the end of a run",
    source="hamr_facts 7, effects 5 and 29 (ageing, temperature)",
)
