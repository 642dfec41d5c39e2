"""Laws: those of the chassis and of tables against closed forms, and each with nothing of it."""

from __future__ import annotations

from math import cos, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stepped_laws import H, parameters

from hamr_dynamics.effects.force_table import hats
from hamr_dynamics.effects.law import Chassis, Input, Joint, Motion, Push, Signal
from hamr_dynamics.effects.library import find, library


def test_a_payload_adds_up_as_bodies_do(rng):
    law = find("added_mass")
    com, at, spin = rng.normal(0, 2, 3), rng.normal(0, 5, 3), rng.normal(0, 1, 3)
    before = Chassis(1.2, tuple(com), (10.0, 20.0, 25.0, 1.0, -2.0, 0.5), (0.0, 0.0, -9.8e-3))
    after, _ = law.law(before, {"mass": 0.5, "x": at[0], "y": at[1], "z": at[2]}, ())
    assert after.mass == pytest.approx(1.7)
    assert after.com == pytest.approx((1.2 * com + 0.5 * at) / 1.7)

    def energy(chassis) -> float:
        """Of a turn about the origin."""
        xx, yy, zz, xy, xz, yz = chassis.inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return 0.5 * spin @ tensor @ spin + 0.5 * chassis.mass * np.sum(np.cross(spin, chassis.com) ** 2)

    assert energy(after) == pytest.approx(energy(before) + 0.25 * np.sum(np.cross(spin, at) ** 2))


def test_slope_and_air():
    roll = find("gravity_tilt").law(Chassis(1.0, (), (), (0.0, 0.0, -1.0)), {"roll": 0.1, "pitch": 0.0}, ())[0].gravity
    assert roll == pytest.approx((0.0, -sin(0.1), -cos(0.1)))  # left side up: it rolls to the right
    pitch = find("gravity_tilt").law(Chassis(1.0, (), (), (0.0, 0.0, -1.0)), {"roll": 0.0, "pitch": 0.1}, ())[0].gravity
    assert pitch == pytest.approx((sin(0.1), 0.0, -cos(0.1)))  # nose down: forward
    drag = find("air_drag").law(Motion((0.0, 0.0, 0.0), (3.0, 0.0, 4.0)), {"coefficient": 0.1}, ())[0]
    assert drag == pytest.approx((-1.5, 0.0, -2.0))


@given(st.floats(-20.0, 20.0))
def test_a_table_goes_on_as_at_its_edge(x):
    weights = np.array(hats(x))
    assert weights.sum() == pytest.approx(1.0)
    assert np.array_equal(weights, hats(np.clip(x, -2.0, 2.0)))
    assert weights @ np.arange(-2.0, 3.0) == pytest.approx(np.clip(x, -2.0, 2.0), abs=1e-12)  # straight lines are exact


@pytest.mark.parametrize(("name", "form"), [(name, form) for name, effect in library().items() for form in effect.forms
                                           if form.acts in ("drive", "force", "sense")])  # fmt: skip
def test_no_size_no_effect(name, form, rng):
    """Exactly: not a bit of signal or force, over fifty steps of noise."""
    p, z = parameters(form), (0.0,) * form.states
    for q, v in rng.normal(0, 1, (50, 2)):
        views = {"drive": Input(q, (q, v), 0, 1.0, H), "force": Joint(q, v, 0.3, 1.0, 1.0, 0.0, H, 9.0), "sense": Signal(q, H)}
        with np.errstate(divide="ignore"):
            answer, z = form.law(views[form.acts], p, z)
        if isinstance(answer, Push):
            assert (answer.force, answer.stiffness, answer.damping, answer.mass, answer.slip) == (0.0,) * 5
        else:
            assert answer == q


@given(*[st.floats(-1.0, 1.0)] * 4)
def test_a_lever_without_a_spring_is_a_force_factor_and_moves_its_tip_besides(q, drive, second, third):
    """Force drive a'(q) of the travel q + a2 q^2 + a3 q^3, whose slope is 1 + 2 a2 q + 3 a3 q^2."""
    effect, at = "configuration_dependent_transmission", Joint(q, 0.0, drive, 1.0, 1.0, 0.0, H, 0.0)
    lever, _ = find(effect, "lever").law(at, {"second": second, "third": third, "share": 0.0}, ())
    factor, _ = find(effect, "force_factor").law(at, {"first": 2.0 * second, "second": 3.0 * third}, ())
    assert factor.force == pytest.approx(lever.force, rel=1e-9, abs=1e-12)
    assert (factor.slip, lever.slip) == (0.0, pytest.approx(q * q * (second + third * q)))
