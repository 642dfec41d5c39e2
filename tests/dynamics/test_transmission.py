"""The five-bar in closed form: its third loop closes, and its foot is that of a universal joint at the hip centre."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_description.numbers import leg_value, value
from hamr_sim_full import transmission
from hamr_sim_full.parameters import leg_parameters
from hamr_sim_residual.simple import simple_leg, simple_parameters

angle = st.floats(-0.65, 0.65)  # beyond the stops
rate = st.floats(-1, 1)
LEGS = ("fl", "rl")
FL = leg_parameters("fl")


@given(angle, angle)
def test_third_loop_closes(swing, lift):
    """Within 1e-5 mm, the published geometry's own precision being 1.4e-7 mm."""
    for leg in LEGS:
        p = leg_parameters(leg)
        assert np.abs(transmission.closure_gap(transmission.solve((swing, lift), p), p)).max() <= 1e-5


@given(angle, angle)
def test_first_two_loops_close(swing, lift):
    """Hinges s3 and l3 stay where the chassis holds them: across z and across x."""
    t = transmission.solve((swing, lift), FL)
    s3 = [float(x.value) for x in transmission.on_s3(t, FL["s3_in_S3"])]
    l3 = [float(x.value) for x in transmission.on_l3(t, FL["l3_in_L3"])]
    assert s3[:2] == pytest.approx(value("leg.closures.s3")[0][:2], abs=1e-9)
    assert l3[1:] == pytest.approx(value("leg.closures.l3")[0][1:], abs=1e-9)


@given(angle, angle)
def test_couplers_keep_their_length(swing, lift):
    """The end of each coupler, reached from the slider, is the hinge reached from the hip."""
    t = transmission.solve((swing, lift), FL)
    s2 = [float(x.value) for x in transmission.on_s2(t, FL, leg_value("fl", "origins.s2"))]
    l2 = [float(x.value) for x in transmission.on_l2(t, FL, leg_value("fl", "origins.l2"))]
    assert s2 == pytest.approx([float(x.value) for x in t.s2], abs=1e-9)
    assert l2 == pytest.approx([float(x.value) for x in t.l2], abs=1e-9)


@given(angle, angle)
def test_s4_and_the_leg_share_their_y_axis(swing, lift):
    turn = transmission.rotations(transmission.solve((swing, lift), FL))
    assert [float(row[1]) for row in turn["S4"]] == pytest.approx([float(row[1]) for row in turn["L4"]], abs=1e-12)


@given(angle, angle, rate, rate)
def test_foot_is_that_of_the_universal_joint(swing, lift, v, w):
    """Rx(lift) Rz(swing) about the hip centre, with its velocity and velocity-product acceleration; HAMR-simple's foot too."""
    foot = transmission.foot(transmission.solve((swing, lift), FL), FL)
    simple = simple_leg((swing, lift), (v, w), (0.0, 0.0), simple_parameters("fl")).foot
    x, y, z = 0.0, 7.58, -13.0
    s, c, u, k = np.sin(swing), np.cos(swing), np.sin(lift), np.cos(lift)
    a, b = c * x - s * y, s * x + c * y
    expected = value("leg.hip") + (a, k * b - u * z, u * b + k * z)
    assert [float(x.value) for x in foot] == pytest.approx(expected, abs=1e-6)
    assert [float(x.value) for x in simple] == pytest.approx(expected, abs=1e-6)
    for quantity in ("rate", "bias"):
        ours = [float(getattr(x, quantity)((v, w))) for x in foot]
        assert ours == pytest.approx([float(getattr(x, quantity)((v, w))) for x in simple], abs=1e-5)


@given(angle, angle)
def test_virtual_work_of_the_tips(swing, lift):
    """Tip motion per hip motion, differenced: the ratios that turn actuator force into hip torque."""
    h = 1e-5
    t = transmission.solve((swing, lift), FL)
    for i, move in enumerate(((h, 0.0), (0.0, h))):
        there, back = (transmission.solve((swing + side * move[0], lift + side * move[1]), FL).tips for side in (1, -1))
        slope = [(float(a.value) - float(b.value)) / (2 * h) for a, b in zip(there, back, strict=True)]
        assert [float(tip.d[i]) for tip in t.tips] == pytest.approx(slope, abs=1e-7)
