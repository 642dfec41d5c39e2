"""Internal loss of a material that is the same at every frequency."""

from __future__ import annotations

from math import log, pi

from ..scalar import sqrt
from .law import Effect, Form, Joint, Parameter, Push

RATIO = 4.0  # between the relaxation times of neighbouring elements
ELEMENTS = 6
#: Stiffness of an element per loss modulus: a dense ladder of equal elements has loss modulus (pi/2) stiffness / ln(ratio).
SHARE = log(RATIO) / (0.5 * pi)


def ladder(x: Joint, p, z):
    """Six Maxwell elements with times a factor of four apart: loss modulus flat within 5 % over 1.4 decades, 10 % over 2.1."""
    return _relaxing(x, p, z, 1.0)


def fractional(x: Joint, p, z):
    """The same with elements that are stiffer the sooner they relax, each `rise` times as stiff as the next slower: the loss modulus, and
    the stiffness with it, grow as a power of the frequency, log4(rise), as of a fractional derivative."""
    return _relaxing(x, p, z, p["rise"])


def _relaxing(x: Joint, p, z, rise):
    k = SHARE * p["loss"] * rise * rise * sqrt(rise)  # of the first; that of the middle of the band is SHARE * loss
    force, stiffness, new = 0.0, 0.0, []
    for i, inner in enumerate(z):
        time = p["time"] * RATIO ** (i - 0.5 * (ELEMENTS - 1))
        moved = (inner * time + x.q * x.step) / (time + x.step)
        new.append(moved)
        force = force - k * (x.q - moved)
        stiffness = stiffness + k * time / (time + x.step)
        k = k / rise
    return Push(force, stiffness=stiffness), tuple(new)


LOSS = Parameter("loss", "F/Q", 0.05, 0.0, 5.0, "loss modulus: loss factor times stiffness")
TIME = Parameter("time", "T", 1.0, 0.03, 30.0, "middle of the band", shape=True, screen=(1.0,))

EFFECT = Effect(
    name="structural_damping",
    part="transmission",
    summary="A loss that takes the same share of the elastic energy at every frequency, or hardly more at higher ones.",
    forms=(Form("ladder", "force", ladder, (LOSS, TIME), states=ELEMENTS), Form("fractional", "force", fractional, (
        LOSS, TIME, Parameter("rise", "1", 1.3, 0.5, 3.0, "of the loss, at four times the frequency", shape=True, screen=(1.3,)),
    ), states=ELEMENTS)),
    experiment="damping measured at several frequencies, by band-wide noise or a slow chirp",
    source="hamr_facts 7, effect 2 (excess damping, b = eta k / omega); generalised Maxwell models; Bagley and Torvik 1983",
    mimics=("viscoelasticity",),  # over a narrow band
)  # fmt: skip
