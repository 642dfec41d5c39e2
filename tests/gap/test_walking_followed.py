"""Whether a walk can be followed at all: even gaits can, drives that jump cannot, and a simulation's exact readings can."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from walks import STEP, driven, walked

from hamr_description.errors import BagError
from hamr_gap.walking.followed import STRETCH_MS, followable, walk_of
from hamr_gap.walking.found import notes, seen_of
from hamr_gap.walking.prepare import LENGTH_MS, prepare
from hamr_gap.walking.robot import Robot
from hamr_gap.walking.walk import FINEST_ANGLE, FINEST_POSITION, FINEST_TURN, Walk


def test_a_trot_leaves_the_noise_and_nothing_else():
    walk, worse = followable(Robot("simple"), walked()[0], LENGTH_MS)
    assert worse < 1.1
    assert walk.noise.angle == pytest.approx(worse * walked()[0].noise.angle)


def test_coarse_encoders_are_no_reason_to_refuse_a_walk_whose_starts_can_be_told():
    walk, _ = walked()
    share = 0.02  # of the range: a gentle pronk by encoders of 0.9 % of the stroke
    coarse = walk.angles + share * np.ptp(walk.angles, axis=0) * np.random.default_rng(3).standard_normal(walk.angles.shape)
    followed, worse = followable(Robot("simple"), replace(walk, angles=coarse), LENGTH_MS)
    assert worse < 1.1
    assert np.median(followed.noise.angle / np.ptp(walk.angles, axis=0)) == pytest.approx(share, rel=0.2)


def test_a_robot_of_our_own_walks_under_the_drives_of_the_other():
    walk, _ = walked()
    own, again = (walk_of(Robot("simple"), walk) for _ in range(2))
    samples = round(STRETCH_MS / STEP)
    assert np.array_equal(own.angles, again.angles)
    assert own.noise is walk.noise
    assert np.diff([0, *own.breaks]).max() <= samples
    (first,) = np.flatnonzero((walk.voltages == own.voltages[0]).all(1))[:1]
    assert np.array_equal(own.voltages[: samples - 1], walk.voltages[first : first + samples - 1])
    assert np.sqrt(np.mean((own.angles[: samples - 1] - walk.angles[first : first + samples - 1]) ** 2)) < 0.2 * walk.angles.std()


def test_drives_that_jump_as_a_policy_makes_them_are_refused_in_a_sentence():
    held = np.random.default_rng(2).uniform(0.0, 225.0, (300, 8))  # targets change every 4 ms, and the drives at once
    walk, _ = driven(np.repeat(held, 80, axis=0))
    with pytest.raises(BagError, match=r"cannot be followed.*by [\d.]+ % of their range within 20 ms.*record drives and poses more often"):
        prepare("simple", walk, lambda _: None)


def test_readings_finer_than_starts_can_be_told_count_as_less_fine():
    exact, _ = walked(0.0)
    walk, worse = followable(Robot("simple"), exact, LENGTH_MS)
    assert 1.1 < worse < 10.0
    assert walk.noise.angle == pytest.approx(worse * FINEST_ANGLE * np.ptp(exact.angles, axis=0))
    assert followable(Robot("simple"), exact, LENGTH_MS)[1] == worse


def test_readings_without_noise_are_as_good_as_those_of_the_finest_sensors():
    t = np.arange(4000) * STEP
    angles = 0.2 * np.sin(0.05 * t[:, None] + np.arange(8.0))
    seen = np.arange(0, 4000, 16)
    position, quaternion = np.sin(0.01 * t[seen, None] + np.arange(3.0)), np.tile([1.0, 0.0, 0.0, 0.0], (len(seen), 1))
    noise = Walk(np.full((4000, 8), 112.5), angles, STEP, seen, position, quaternion).noise
    assert noise.angle == pytest.approx(FINEST_ANGLE * np.ptp(angles, axis=0))
    assert (noise.position == FINEST_POSITION).all() and (noise.turn == FINEST_TURN).all()


def test_what_counts_as_noise_is_said_and_holds_for_the_readings_that_are_shown():
    assert "2.6 times as noisy" in notes(2.64)[-1]
    assert notes(1.1) == notes(1.0)
    noise = replace(walked()[0], known=None).noise
    found = SimpleNamespace(simulation={"noise": [[3.0 * x for x in each] for each in (noise.angle, noise.position, noise.turn)]})
    shown = seen_of(found, walked()[0])
    assert shown.noise.angle == pytest.approx(3.0 * noise.angle)
    assert shown.noise.turn == pytest.approx(3.0 * noise.turn)


def test_drives_under_which_the_model_diverges_are_refused_in_a_sentence():
    walk, _ = walked()
    with pytest.raises(BagError, match="diverges under the drives of this walk"):
        followable(Robot("simple"), replace(walk, voltages=1e6 * walk.voltages), LENGTH_MS)
