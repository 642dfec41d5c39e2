"""What is left of a walk, in all and in parts: what acts on the chassis alone shows in few readings of many."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from walks import walked

from hamr_gap.walking.followed import STRETCH_MS, walk_of
from hamr_gap.walking.left import WORST, Judged, exceeds, floors, left_of
from hamr_gap.walking.prepare import LENGTH_MS, Prepared
from hamr_gap.walking.replay import Replay
from hamr_gap.walking.robot import Robot
from hamr_gap.walking.segments import CHANGES, segments
from hamr_gap.walking.setting import Setting
from hamr_gap.walking.starts import Started, start

PITCH = 5  # of the parts, behind the angles, the position and the roll
LEAST = 0.25


@cache
def own() -> tuple[Replay, Started]:
    """A walk of the model itself with the noise of the sensors, followed."""
    walk = walk_of(Robot("simple"), walked()[0])
    replay = Replay.of(Robot("simple"), segments(walk, length_ms=LENGTH_MS, every_ms=STRETCH_MS))
    return replay, start(replay, Setting())


def judged(parts: np.ndarray, weights: np.ndarray) -> Judged:
    return Judged((), None, float(weights @ parts), np.ones(12), parts)


def weights() -> np.ndarray:
    """Shares of the readings that are angles, or of an axis."""
    replay, _ = own()
    angles, poses = replay.observed.angle_readings * len(replay), replay.observed.there.sum()
    return np.array([angles, *[poses] * 6]) / (angles + 6 * poses)


def test_parts_are_the_means_of_their_readings():
    replay, begun = own()
    s, g = replay.observed.angles.shape[:2]
    pitch = np.arange(8 * g, replay.observed.readings, 6) + PITCH - 1
    there = replay.observed.there
    each = np.random.default_rng(0).random((s, replay.observed.readings))
    parts = replay.observed.parts(each)
    assert parts[0] == pytest.approx(each[:, : 8 * g].mean())
    assert parts[PITCH] == pytest.approx(each[:, pitch][there].mean())
    left, _, parts = left_of(replay, begun)
    every = np.mean(begun.residual[:, :-CHANGES] ** 2, 1)
    assert left == pytest.approx(np.sort(every)[: round((1 - WORST) * s)].mean())
    assert left == pytest.approx(weights() @ parts, rel=0.02)  # where as many poses are seen of each segment


def test_noise_leaves_of_each_part_what_starts_do_not_take_up():
    replay, begun = own()
    noise = floors(replay, replay.slopes(begun.change, begun.residual, Setting()))
    assert replay.observed.parts(begun.residual[:, :-CHANGES] ** 2) == pytest.approx(noise, rel=0.25)
    assert (noise < 1.0).all()
    assert 1.0 - CHANGES / replay.observed.readings < weights() @ noise < 1.0


@pytest.mark.parametrize(("off", "part", "gap"), [
    (2.0, PITCH, True), (0.2, PITCH, False), (0.3, slice(None), True), (0.2, slice(None), False),
])  # fmt: skip
def test_what_one_axis_shows_is_a_gap_though_hardly_any_reading_is_of_it(off, part, gap):
    replay, begun = own()
    noise = floors(replay, replay.slopes(begun.change, begun.residual, Setting()))
    more = noise.copy()
    more[part] += off
    base, best = (judged(parts, weights()) for parts in (more, noise))
    assert exceeds(base, best, LEAST) == gap
    assert not exceeds(best, base, LEAST)
    base = replace(base, fit=SimpleNamespace(model=Setting()))
    prepared = Prepared({"fit": replay, "select": replay}, {"select": begun}, base, base, 0.0, float(weights() @ noise), 1.0)
    assert prepared.least == LEAST
    assert prepared.gap == gap
