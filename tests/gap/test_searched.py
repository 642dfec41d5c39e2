"""What is worth searching for, and what is said where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shaken_leg import BESIDE, FRICTION, NOISE, shaken

from hamr_gap.data.record import Record
from hamr_gap.fitting.scales import scales_of
from hamr_gap.fitting.weighed import SMALLEST
from hamr_gap.judging.analyse import SIGNIFICANT, analyse
from hamr_gap.judging.detect import detectable
from hamr_gap.legs import machine_of
from hamr_gap.naming import search
from hamr_gap.naming.blocks import better
from hamr_gap.naming.candidates import candidates, of_one_size
from hamr_gap.naming.hypothesis import left_of
from hamr_gap.naming.moves import look
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.search import Search, noise_floor
from hamr_gap.naming.searched import gap_searched

LEG = machine_of("simple", "fl")


@pytest.fixture(scope="module")
def plain() -> Record:
    """A leg that is its model."""
    return shaken("coulomb_friction.presliding", {})


def searched(record: Record, monkeypatch) -> Search:
    """With three names only."""
    monkeypatch.setattr(search, "candidates", lambda *_: [FRICTION, *BESIDE])
    return gap_searched(prepare(LEG, record), lambda _: None)


def test_where_no_gap_is_left_no_name_is_tried(plain, monkeypatch):
    state = searched(plain, monkeypatch)
    assert not state.tried
    assert state.best is state.base
    assert state.base.left - state.floor < state.weighed.least


def test_what_a_record_without_a_gap_would_have_shown_needs_few_forms(plain):
    """As sizes of all forms say it."""
    prepared = prepare(LEG, plain)
    everything = candidates(LEG, plain)
    whole, few = (look(prepared.weighed, prepared.base.fit, some) for some in (everything, of_one_size(everything)))
    assert len(few.columns) < 0.3 * len(whole.columns)
    least = 0.5 * prepared.weighed.least * prepared.weighed.chosen.sum()
    assert detectable(LEG, scales_of(LEG, plain), few, least=least) == detectable(LEG, scales_of(LEG, plain), whole, least=least)


@pytest.mark.parametrize("share, tried", [(0.5, False), (1.5, True)])
def test_a_gap_is_searched_from_the_least_that_counts_on(plain, monkeypatch, share, tried):
    """Both sensors show a slow tone that no name explains, and no difference of readings: a share of the least gap."""
    rms = np.sqrt(share) * SMALLEST * NOISE * np.ptp(plain.readings, axis=0)
    tone = np.sqrt(2.0) * rms * np.sin(0.09 * plain.step * np.arange(len(plain)))[:, None]
    assert bool(searched(replace(plain, readings=plain.readings + tone), monkeypatch).tried) == tried


def test_steps_of_a_sensor_that_look_like_noise_are_searched(plain, monkeypatch):
    """The swing's encoder knows 60 angles, several of which pass between two readings, and rounds none of its own."""
    readings = plain.readings.copy()
    step = np.ptp(readings[:, 0]) / 60.0
    readings[:, 0] = step * (np.round(readings[:, 0] / step) + 1e-4 * np.random.default_rng(0).standard_normal(len(plain)))
    state = searched(replace(plain, readings=readings), monkeypatch)
    assert state.base.left - noise_floor(state.weighed, state.base) < state.weighed.least
    assert ("sensor_quantisation", (0,)) in state.best.names


@pytest.mark.parametrize("share, verdict", [(0.5, "no_significant_gap"), (2.0, "parameters_only")])
def test_parameters_close_a_gap_only_where_there_is_one(plain, share, verdict):
    """Every sensor is off, for sure, by a share of the least that counts as a gap."""
    bias = np.sqrt(share) * SMALLEST * NOISE * np.ptp(plain.readings, axis=0)
    found = analyse(LEG, replace(plain, readings=plain.readings + bias))
    plainly = left_of(found.prepared.weighed, found.prepared.judged, found.prepared.weighed.model.plain)[1]
    assert better(plainly, found.prepared.base.blocks) > SIGNIFICANT
    assert found.verdict.verdict == verdict
