"""What else may stand in the place of an effect, on a leg of HAMR-simple whose drive is cut on one side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shaken_leg import shaken

from hamr_gap.fitting.parameters import Candidate
from hamr_gap.legs import machine_of
from hamr_gap.naming.candidates import candidates
from hamr_gap.naming.exchange import TWINS, twins
from hamr_gap.naming.hypothesis import Hypothesis, refined
from hamr_gap.naming.moves import look, singles
from hamr_gap.naming.prepare import Prepared, prepare
from hamr_gap.naming.simpler import bare
from hamr_gap.naming.tried import Search

GAIN = Candidate("voltage_dependent_gain", "one_sided", (0,))
CUT = Candidate("drive_saturation", "sides", (0,))


@pytest.fixture(scope="module")
def cut() -> Prepared:
    """At 30 V, where the drive is 40 V rms."""
    return prepare(machine_of("simple", "fl"), shaken("drive_saturation.sides", {"upper.0": 1.0 / 30.0}))


@pytest.fixture(scope="module")
def gain(cut) -> Hypothesis:
    """A gain that falls about some voltage."""
    seen = look(cut.weighed, cut.base.fit, [GAIN])
    return min(refined(cut.weighed, cut.judged, singles(cut.weighed, cut.base.fit, seen, [GAIN])), key=lambda h: h.left)


def looked(cut: Prepared, *tried: Hypothesis) -> list[Hypothesis]:
    """What is tried besides."""
    weighed = cut.weighed
    everything = candidates(weighed.model.machine, weighed.model.record)
    state = Search(weighed, cut.base, look(weighed, cut.base.fit, [GAIN]), int(cut.judged.sum()), list(tried))
    twins(weighed, cut.judged, state, everything)
    return state.tried[len(tried) :]


def test_another_name_is_found_about_the_re_tune_that_was_found_with_one(cut, gain):
    """About the one that was found without it does not come near."""
    found = looked(cut, gain)
    best = min(found, key=lambda h: h.left)
    assert best.names == frozenset({CUT.name})
    assert best.left < 1.1 < 0.01 * gain.left < 0.001 * cut.base.left
    assert {place for h in found for c in h.effects for place in c.places} == set(GAIN.places)
    own = np.array([*cut.base.fit.x, *gain.fit.x[len(cut.base.fit.x) :]])
    assert best.names not in {h.names for h in looked(cut, replace(gain, fit=replace(gain.fit, x=own)))}


def test_what_is_known_to_leave_as_little_is_not_tried_again(cut, gain):
    alike = Hypothesis((CUT,), gain.fit, 3.9 * gain.left, gain.blocks)
    for other, again in ((alike, False), (replace(alike, left=4.1 * gain.left), True)):
        names = {h.names for h in looked(cut, gain, other)}
        assert gain.names not in names
        assert (alike.names in names) == again


def test_what_is_tried_races_against_the_best_there_is(cut, gain, monkeypatch):
    told = []
    monkeypatch.setattr("hamr_gap.naming.exchange.refined", lambda weighed, judged, found, known: told.append((len(found), known)) or [])
    looked(cut, gain)
    assert told == [(TWINS, [gain])]


def test_nothing_is_looked_for_in_the_place_of_several(cut, gain):
    """Of these each has been exchanged."""
    assert looked(cut, replace(gain, effects=(GAIN, Candidate("quadratic_damping", "square", (1,))))) == []


def test_the_re_tune_beside_an_effect_stays_as_it_was_found(gain, cut):
    alone = bare(cut.weighed, gain)
    assert alone.x.tolist() == gain.fit.x[: len(alone.x)].tolist()
    assert {f.row.split(".")[0] for f in alone.free} == {"change"}
