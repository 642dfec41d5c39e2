"""Something that the joint hits inside its travel."""

from __future__ import annotations

from ..scalar import maximum, positive
from ..stops import touching
from .law import Effect, Form, Joint, Parameter, Push

STIFFNESS = Parameter("stiffness", "F/Q", 2.0, 0.0, 1e4, "of the stop")
#: Close, since a run that hits elsewhere than the machine did leads nowhere; far, since "usual" is the rms of both joints.
LIMITS = (0.8, 1.2, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6, 2.8, 3.1, 3.5, 4.0)
LIMIT = Parameter("limit", "Q", 1.5, 0.1, 6.0, "angle from rest at which it begins", shape=True, screen=LIMITS)
DAMPING = Parameter("damping", "F*T/Q", 0.05, 1e-6, 10.0, "while it pushes", shape=True, screen=(0.05,))


def _side(depth, rate, step, p):
    """Mean force, stiffness and damping over a step that may touch for a part of it only."""
    share, depth = touching(depth, rate, step)
    stiffness, damping = share * p["stiffness"], share * positive(p["stiffness"]) * p["damping"]
    return maximum(stiffness * depth + damping * rate, 0.0), stiffness, damping


def both(x: Joint, p, z):
    """Springs and dampers beyond +-limit that never pull."""
    up, k_up, d_up = _side(x.q - p["limit"], x.v, x.step, p)
    down, k_down, d_down = _side(-x.q - p["limit"], -x.v, x.step, p)
    return Push(down - up, stiffness=k_up + k_down, damping=d_up + d_down), z


def upper(x: Joint, p, z):
    """Beyond +limit only."""
    push, k, d = _side(x.q - p["limit"], x.v, x.step, p)
    return Push(-push, stiffness=k, damping=d), z


def lower(x: Joint, p, z):
    """Beyond -limit only."""
    push, k, d = _side(-x.q - p["limit"], -x.v, x.step, p)
    return Push(push, stiffness=k, damping=d), z


EFFECT = Effect(
    name="end_stop",
    part="transmission",
    summary="A stop inside the travel of a joint, on one side or both.",
    forms=tuple(Form(law.__name__, "force", law, (STIFFNESS, LIMIT, DAMPING)) for law in (both, upper, lower)),
    experiment="amplitudes up to the full stroke",
    source="hamr_facts 7, effect 22 (leg meets chassis, flexure stops)",
)
