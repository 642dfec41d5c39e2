"""Which targets hold: bad ones never, late ones never, those in lock-step exactly when they answer the present state."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_controller.health import FRESH_S, Health, Level
from hamr_controller.joints import BadMessage
from hamr_controller.law import Gains
from hamr_controller.leg_controller import LegController
from hamr_controller.targets import LIMIT, Targets, checked
from hamr_description.names import JOINTS
from hamr_description.rates import TARGET_NS

ZERO = [0.0] * 8


class Clock:
    """Wall time that moves by hand."""

    def __init__(self):
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@given(st.permutations(range(8)), st.lists(st.floats(-LIMIT, LIMIT), min_size=8, max_size=8))
def test_joints_count_by_name_not_by_place(order, values):
    shuffled = checked([JOINTS[j] for j in order], [values[j] for j in order])
    assert shuffled.tolist() == values


BAD = {
    "no joint of this robot": (["nose", *JOINTS[1:]], ZERO),
    "'fl_lift' 2 times": ([JOINTS[1], *JOINTS[1:]], ZERO),
    "lacks 'rr_lift'": (JOINTS[:7], ZERO[:7]),
    "7 values for 8": (JOINTS, ZERO[:7]),
    "nan for 'rl_swing'": (JOINTS, [0, 0, float("nan"), 0, 0, 0, 0, 0]),
    "inf for 'fl_swing'": (JOINTS, [float("inf"), *ZERO[1:]]),
    "0.4365 rad for 'rr_lift'": (JOINTS, [*ZERO[:7], np.deg2rad(25.01)]),
    "-0.4365 rad for 'fl_lift'": (JOINTS, [0.0, -np.deg2rad(25.01), *ZERO[2:]]),
    "lacks": ([], []),
}


@pytest.mark.parametrize("said", BAD)
def test_a_bad_message_is_named_and_changes_nothing(said):
    targets = Targets(lockstep=True, patience_s=1.0, age_s=0.1)
    names, position = BAD[said]
    with pytest.raises(BadMessage, match=r"/leg_targets .*\.$") as error:
        targets.accept(names, position, 0, 0)
    assert said in str(error.value)
    assert targets.decide(0) == (True, None) and not targets.following


@pytest.mark.parametrize(("stamp", "now", "said"), [(1, 0, "it is 0.000 s"), (0, 26 * TARGET_NS, "stale at 0.104 s")])
def test_a_stamp_from_the_future_or_the_past_is_refused(stamp, now, said):
    targets = Targets(lockstep=False, patience_s=1.0, age_s=0.1)
    with pytest.raises(BadMessage, match=said):
        targets.accept(JOINTS, ZERO, stamp, now)
    assert targets.decide(now) == (True, None)


def test_in_lockstep_a_period_waits_for_its_own_targets_and_no_longer_than_its_patience():
    clock = Clock()
    targets = Targets(lockstep=True, patience_s=0.5, age_s=0.1, clock=clock)
    assert targets.decide(0) == (True, None)  # nobody ever sent any: nothing to wait for
    targets.accept(JOINTS, [0.1] * 8, 0, 0)
    assert targets.decide(0)[1].tolist() == [0.1] * 8
    now = TARGET_NS
    assert targets.decide(now) == (False, None)
    targets.accept(JOINTS, [0.2] * 8, 0, now)  # an answer to the state before counts for that one only
    assert targets.decide(now) == (False, None)
    targets.accept(JOINTS, [0.3] * 8, now, now)
    targets.accept(JOINTS, [0.4] * 8, now, now)  # sent twice: the first counts
    assert targets.decide(now)[1].tolist() == [0.3] * 8
    now += TARGET_NS
    assert targets.decide(now) == (False, None)
    clock.now += 0.49
    assert targets.decide(now) == (False, None)
    clock.now += 0.02
    assert targets.decide(now) == (True, None)
    assert targets.decide(now + TARGET_NS) == (True, None)  # stopped: nobody waits any more
    targets.accept(JOINTS, ZERO, now, now + TARGET_NS)  # back, a period late
    assert targets.decide(now + 2 * TARGET_NS) == (False, None)
    targets.forget()
    assert targets.decide(0) == (True, None)


def test_without_lockstep_the_newest_targets_hold_until_they_are_too_old():
    targets = Targets(lockstep=False, patience_s=1.0, age_s=0.02)
    targets.accept(JOINTS, [0.1] * 8, 0, 0)
    for period in range(6):
        assert targets.decide(period * TARGET_NS)[1].tolist() == [0.1] * 8
    assert targets.decide(6 * TARGET_NS) == (True, None)


def controller(clock: Clock):
    told, sent = [], []
    health = Health(lambda level, sentence: told.append((level, sentence)), clock=clock)
    targets = Targets(lockstep=True, patience_s=0.5, age_s=0.1, clock=clock)
    return LegController(targets, Gains.default(), health, lambda ns, volts: sent.append((ns, volts.copy()))), health, told, sent


def test_the_controller_is_neutral_without_targets_and_says_so_once():
    clock = Clock()
    leg, health, told, sent = controller(clock)
    for period in range(3):
        plan = leg.plan(period)
        assert (plan.feed == 112.5).all() and not plan.kp.any()
    assert [level for level, _ in told] == [Level.WARN] and "neutral voltage" in told[0][1]
    assert health.status()[0] == Level.WARN and health.status()[2]["periods without targets"] == "3"
    leg.hear(JOINTS, [0.1] * 8, 3 * TARGET_NS, 3)
    assert leg.plan(3).target.tolist() == [0.1] * 8
    assert health.status()[:2] == (Level.OK, "ok")
    volts = np.full((80, 8), 112.5)
    volts[0, 0], volts[1, 1] = 0.0, 225.0
    leg.done(3, volts)
    leg.report()
    assert sent[0][0] == 3 * TARGET_NS and health.figures["saturation"] == pytest.approx(2 / 640)


def test_a_refused_message_is_logged_once_and_stays_in_the_status_for_a_while():
    clock = Clock()
    leg, health, told, _ = controller(clock)
    for _ in range(100):
        leg.hear(["nose", *JOINTS[1:]], ZERO, 0, 0)
    assert len(told) == 1
    level, message, values = health.status()
    assert level == Level.WARN and "nose" in message and values["refused"] == "100"
    clock.now += FRESH_S + 1
    assert health.status()[:2] == (Level.OK, "ok")
    leg.hear(["nose", *JOINTS[1:]], ZERO, 0, 0)
    assert len(told) == 2


def test_a_flood_of_different_mistakes_does_not_flood_the_log():
    clock = Clock()
    leg, health, told, _ = controller(clock)
    for i in range(1000):
        leg.hear(JOINTS, [1.0 + i, *ZERO[1:]], 0, 0)
    assert 1 < len(told) < 50 and health.counts["refused"] == 1000
