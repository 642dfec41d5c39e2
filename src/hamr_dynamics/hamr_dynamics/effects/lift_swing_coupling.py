"""The two joints of a leg act on each other more than the model says."""

from __future__ import annotations

from .law import Effect, Form, Pair, PairPush, Parameter


def stiffness(x: Pair, p, z):
    """Off-diagonal spring."""
    k = p["stiffness"]
    return PairPush((-(k * x.q[1]), -(k * x.q[0])), stiffness=(0.0, k, 0.0)), z


def damping(x: Pair, p, z):
    """Off-diagonal damper."""
    d = p["damping"]
    return PairPush((-(d * x.v[1]), -(d * x.v[0])), damping=(0.0, d, 0.0)), z


def inertia(x: Pair, p, z):
    """Off-diagonal inertia."""
    return PairPush(mass=(0.0, p["inertia"], 0.0)), z


EFFECT = Effect(
    name="lift_swing_coupling",
    part="body",
    summary="A spring, damper or inertia between the lift and the swing of a leg.",
    forms=(
        Form("stiffness", "pair", stiffness, (Parameter("stiffness", "F/Q", 0.03, -2.0, 2.0, "off-diagonal stiffness"),)),
        Form("damping", "pair", damping, (Parameter("damping", "F*T/Q", 0.03, -2.0, 2.0, "off-diagonal damping"),)),
        Form("inertia", "pair", inertia, (Parameter("inertia", "F*T^2/Q", 0.03, -2.0, 2.0, "off-diagonal inertia"),)),
    ),
    experiment="drive one joint alone and watch the other",
    source="hamr_facts 7, effect 9",
)
