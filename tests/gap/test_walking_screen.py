"""The linear picture of a walk, of robots whose payload MuJoCo carries."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.names import JOINTS
from hamr_gap.walking.bags import read
from hamr_gap.walking.candidates import forms
from hamr_gap.walking.fit import Fit
from hamr_gap.walking.looks import OUTSIDE
from hamr_gap.walking.replay import Replay
from hamr_gap.walking.robot import Numerics, Robot
from hamr_gap.walking.screen import NEUTRAL, Screen
from hamr_gap.walking.segments import segments
from hamr_gap.walking.setting import Candidate, Setting, retune
from hamr_gap.walking.starts import start
from hidden_gap.case import Effect
from hidden_gap.ground import write
from hidden_gap.ground.case import GroundCase

TROT = {"kind": "trot", "seconds": 1.2, "frequency_hz": 16.0, "amplitude": 50.0}


def picture(folder, effect, of) -> Screen:
    """Of the forms of which `of` holds, about a model without an effect that the robot has."""
    write(GroundCase("a", "ground", 1, (effect,), {}, 1.2, TROT, 3e-3), folder)
    robot = Robot("simple", Numerics(1, 0.1))
    replay = Replay.of(robot, segments(read([folder]), length_ms=20.0, every_ms=20.0))  # with half of them last digits decide
    begun, free = start(replay, Setting()), tuple(retune(robot.rest()))
    about = Fit(free, np.zeros(len(free)), (), begun.change, begun.residual, float(begun.cost.sum()), np.eye(len(free)))
    return Screen(replay, about, [(e, form) for e, form in forms() if of(e, form)])


@pytest.mark.parametrize("end", [1, -1])
def test_a_payload_at_an_end_is_seen_there(tmp_path, end):
    """A re-tune takes up much of a weight at the centre of mass; what it cannot take up is where the weight sits."""
    payload = Effect("added_mass", (), "payload", {"mass": 0.2, "forward": 9.0 * end, "left": 0.0, "up": 8.0})
    seen = picture(tmp_path / "walk", payload, lambda _, form: form.acts in OUTSIDE)
    first, payload = seen.singles()[0], Candidate("added_mass", "point", "chassis")
    gain = {(x, z): seen.solve([payload], [(("x", x), ("y", 0.0), ("z", z))]).gain for x in (-10.0, 0.0, 10.0) for z in (0.0, 10.0)}
    assert first.effects == (payload,) and first.values[payload.row(payload.law.shapes[2])] == 10.0
    assert gain[10.0 * end, 10.0] > 2.0 * gain[-10.0 * end, 10.0] and first.gain > 2.0 * gain[0.0, 0.0]


def test_a_limit_that_only_the_peaks_of_a_drive_pass_is_seen(tmp_path):
    """A limit that the drive never meets does nothing, and one far below it is no picture of one just below."""
    limit = 46.0  # V, of a drive of 50
    clip = Effect("drive_saturation", JOINTS, "hard_clip", {"depth": 1.0 - limit / NEUTRAL, "side": 0.0})
    seen = picture(tmp_path / "walk", clip, lambda effect, _: effect in ("drive_saturation", "drive_lag", "cubic_stiffness"))
    first = seen.singles()[0]
    assert first.effects[0].name == ("drive_saturation", "all")
    for form in ("hard", "sides"):
        c = Candidate("drive_saturation", form, "all")
        (values,) = (s.values for s in seen.singles() if s.effects == (c,))
        assert [1.0 / (values[c.row(p)] * c.scale(p)) for p in c.law.sizes] == pytest.approx([limit] * len(c.law.sizes), rel=0.05)
