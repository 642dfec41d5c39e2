"""Hidden laws that a form of the library is too, written by another hand: the name stands for both."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from test_hidden_laws import drive

from hamr_dynamics.effects.law import Form, Joint, Pair
from hamr_dynamics.effects.library import find
from hamr_gap.fitting.scales import scales_of
from hamr_gap.flagship_find import recorded
from hamr_gap.legs import machine_of
from hidden_gap.laws.law import LAWS, TAU

angle = st.floats(-0.5, 0.5)


def _sizes(form: Form, **given: float) -> dict[str, float]:
    return {p.name: 0.0 for p in form.parameters} | given


@given(angle, angle, st.floats(0.01, 6.0))
def test_three_waves_are_a_potential_of_both_angles(swing, lift, pull):
    torque = drive("three_waves", {"pull": pull}, q=np.array([[swing, lift]]), joints=(0, 1))[0, TAU : TAU + 2]
    form = find("configuration_dependent_stiffness", "potential")
    push, _ = form.law(Pair((swing, lift), (0.0, 0.0), (0.0, 0.0), (0.5, 0.5), (1.0, 1.0), 0.1), _sizes(form, c21=pull, c12=-pull), ())
    assert_allclose(push.force, torque, rtol=1e-12, atol=1e-12)
    assert LAWS["three_waves"].family == "configuration_dependent_stiffness"


@given(angle, st.floats(-110.0, 110.0), st.floats(1e-5, 5e-3))
def test_a_spring_that_the_voltage_tunes_is_a_force_that_the_angle_does(q, volts, softening):
    gain = 1.6e-3  # N mm/V
    torque = drive("voltage_spring", {"softening": softening}, q=[q], u=[volts])[0, TAU]
    form = find("configuration_dependent_transmission", "force_factor")
    push, _ = form.law(Joint(q, 0.0, gain * volts, 0.5, 1.0, 0.0, 0.1, 0.0), _sizes(form, first=-softening / gain), ())
    assert push.force == pytest.approx(torque, rel=1e-12, abs=1e-15)
    assert push.slip == 0.0  # a lever moves its tip besides
    assert LAWS["voltage_spring"].family == "configuration_dependent_transmission"


def test_wells_may_be_as_narrow_as_a_snap():
    """At half of its depth, on a leg under the paper's noise; a hump's potential is a Gaussian of the width that is hidden."""
    form = find("configuration_dependent_stiffness", "well")
    (least,) = (p.low for p in form.parameters if p.name == "width")
    record = recorded("fl", seconds=2.0, noise=1e-3, seed=0)
    narrowest = np.sqrt(2.0 * np.log(2.0)) * LAWS["snap"].ranges["width"][0]
    assert least * scales_of(machine_of("simple", "fl"), record).coordinate < narrowest
    assert LAWS["snap"].family == "configuration_dependent_stiffness"
