"""The linear picture of a walk, of robots whose payload MuJoCo carries."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_gap.walking.bags import read
from hamr_gap.walking.candidates import forms
from hamr_gap.walking.fit import Fit
from hamr_gap.walking.looks import OUTSIDE
from hamr_gap.walking.replay import Replay
from hamr_gap.walking.robot import Numerics, Robot
from hamr_gap.walking.screen import Screen
from hamr_gap.walking.segments import segments
from hamr_gap.walking.setting import Candidate, Setting, retune
from hamr_gap.walking.starts import start
from hidden_gap.case import Effect
from hidden_gap.ground import write
from hidden_gap.ground.case import GroundCase

TROT = {"kind": "trot", "seconds": 1.2, "frequency_hz": 16.0, "amplitude": 50.0}


@pytest.mark.parametrize("end", [1, -1])
def test_a_payload_at_an_end_is_seen_there(tmp_path, end):
    """A re-tune takes up much of a weight at the centre of mass; what it cannot take up is where the weight sits."""
    payload = Effect("added_mass", (), "payload", {"mass": 0.2, "forward": 9.0 * end, "left": 0.0, "up": 8.0})
    write(GroundCase("a", "ground", 1, (payload,), {}, 1.2, TROT, 3e-3), tmp_path / "walk")
    robot = Robot("simple", Numerics(1, 0.1))
    replay = Replay.of(robot, segments(read([tmp_path / "walk"]), length_ms=20.0, every_ms=20.0))  # with half of them last digits decide
    begun, free = start(replay, Setting()), tuple(retune(robot.rest()))
    about = Fit(free, np.zeros(len(free)), (), begun.change, begun.residual, float(begun.cost.sum()), np.eye(len(free)))
    seen = Screen(replay, about, [(e, form) for e, form in forms() if form.acts in OUTSIDE])
    first, payload = seen.singles()[0], Candidate("added_mass", "point", "chassis")
    gain = {(x, z): seen.solve([payload], [(("x", x), ("y", 0.0), ("z", z))]).gain for x in (-10.0, 0.0, 10.0) for z in (0.0, 10.0)}
    assert first.effects == (payload,) and first.values[payload.row(payload.law.shapes[2])] == 10.0
    assert gain[10.0 * end, 10.0] > 2.0 * gain[-10.0 * end, 10.0] and first.gain > 2.0 * gain[0.0, 0.0]
