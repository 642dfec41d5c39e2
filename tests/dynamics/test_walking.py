"""The kernel and MuJoCo walk alike. One cell in small; `python -m hamr_bringup.walking` runs them all (docs/contact.md)."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_bringup.walking import GAITS, SETTLE, Gait, Starts, compare, forward


def test_speeds_agree_on_one_gait_and_surface():
    """HAMR-simple, trot at 30 Hz on card, from 8 jittered starts: medians within 5 %, and the robot walks."""
    cell = compare("simple", "trot 30 Hz", "card", 8)
    assert abs(cell["difference"]) <= 0.05
    assert cell["kernel"] > 100, "mm/s"


def test_speed_is_along_the_heading():
    """A robot that goes round a circle nose first covers the arc; sideways, nothing."""
    angle = np.linspace(0, np.pi, 401)
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)[:, None]
    for offset, share in ((np.pi / 2, 1.0), (0.0, 0.0)):
        yaw = angle + offset
        turn = np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1)[:, None]
        assert forward(circle, turn)[0] == pytest.approx(share * np.pi, abs=0.02)


def test_gaits_move_every_foot_and_mirror_left_and_right():
    """Voltages stay within the supply, no two legs of a trot's diagonal differ, and the start's phase shifts them."""
    t = np.arange(400) * 0.05
    for gait in GAITS.values():
        volts = gait.volts(t, np.array([0.0, 0.5]))
        assert volts.min() >= 0.0
        assert volts.max() <= 225.0
        assert (np.ptp(volts[0], axis=0) > 10.0).all()
        assert volts[1] == pytest.approx(225.0 - volts[0], abs=1e-9), "half a stride later everything is reversed"
        assert gait.strides >= 10 > SETTLE
    assert Gait(10, 50, 25, (0.0, 0.5, 0.5, 0.0), 1).volts(t, np.zeros(1)).shape == (1, 400, 8)


def test_starts_differ_and_repeat():
    one, again, other = Starts.random(64, 1), Starts.random(64, 1), Starts.random(64, 2)
    assert np.array_equal(one.quaternion(), again.quaternion())
    assert not np.array_equal(one.phase, other.phase)
    assert np.abs(np.linalg.norm(one.quaternion(), axis=1) - 1).max() < 1e-12
