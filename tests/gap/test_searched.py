"""What is worth searching for, and what is said where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shaken_leg import BESIDE, FRICTION, NOISE, shaken

from hamr_dynamics.effects.library import library
from hamr_gap.data.readings import noise_of
from hamr_gap.data.record import Record
from hamr_gap.fitting.scales import scales_of
from hamr_gap.judging.analyse import SIGNIFICANT, analyse, hidden
from hamr_gap.judging.detect import detectable
from hamr_gap.judging.verdict import Gap
from hamr_gap.legs import machine_of
from hamr_gap.naming import search
from hamr_gap.naming.blocks import better
from hamr_gap.naming.candidates import candidates, of_one_size
from hamr_gap.naming.hypothesis import left_of
from hamr_gap.naming.moves import look
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.searched import gap_searched
from hamr_gap.naming.tried import Search, noise_floor

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


@pytest.mark.parametrize("lag, several", [(0.0, False), (1.0, True)])
def test_single_effects_are_fitted_from_elsewhere_where_two_seem_to_be_missing(monkeypatch, lag, several):
    """Friction alone, and with a drive at the other joint that lags by a millisecond."""
    asked = []
    monkeypatch.setattr(search, "from_elsewhere", lambda *_: asked.append(True) or [])
    beside = {"drive_lag.first_order": {"time.1": lag}}
    state = searched(shaken("coulomb_friction.presliding", {"level.0": 4e-3, "distance.0": 0.005}, **beside), monkeypatch)
    assert len(state.fewest.effects) == 1 + several
    assert bool(asked) == several


def test_what_a_record_without_a_gap_would_have_shown_needs_few_forms(plain):
    """As the picture of all forms says it."""
    prepared = prepare(LEG, plain)
    everything = candidates(LEG, plain)
    simplest = of_one_size(everything)
    least = 0.5 * prepared.weighed.least * prepared.weighed.chosen.sum()
    whole, few = (look(prepared.weighed, prepared.base.fit, some) for some in (everything, simplest))
    said, also = (detectable(LEG, scales_of(LEG, plain), seen, simplest, least=least) for seen in (whole, few))
    assert len(few.columns) < 0.3 * len(whole.columns)
    assert said == also
    assert set(said["coulomb_friction"]) == set(LEG.joints)
    assert set(said["lift_swing_coupling"]) == {"both"}


def test_no_effect_is_said_to_stand_out_that_hides_in_what_is_unexplained(plain):
    """A cart that left seven times the noise was told how little friction it would have shown, a fortieth of what it had."""
    prepared = prepare(LEG, plain)
    count, mean = prepared.weighed.chosen.sum(), prepared.weighed.model.mean
    gap = Gap(raw=9.0, retuned=7.0, after=1.0, floor=1.0, per_channel={})
    assert hidden(prepared, gap) == pytest.approx(0.5 * prepared.weighed.least * count)
    assert hidden(prepared, replace(gap, after=7.0)) == pytest.approx(0.5 * mean * 48.0 * count)
    wanted = of_one_size(candidates(LEG, plain))
    seen = look(prepared.weighed, prepared.base.fit, wanted)
    little, much = (
        detectable(LEG, scales_of(LEG, plain), seen, wanted, least=hidden(prepared, replace(gap, after=after)))["coulomb_friction"]
        for after in (1.0, 7.0)
    )
    for joint in LEG.joints:
        assert float(much[joint].split()[0]) > 20.0 * float(little[joint].split()[0])


def test_no_size_is_said_to_be_seen_that_is_beyond_what_is_looked_for(plain):
    """A pendulum's record was said to show a delay of 24 s."""
    prepared, wanted = prepare(LEG, plain), of_one_size(candidates(LEG, plain))
    seen, scales = look(prepared.weighed, prepared.base.fit, wanted), scales_of(LEG, plain)
    said, nothing = (detectable(LEG, scales, seen, wanted, least=least) for least in (0.0, 1e12))
    most = library()["drive_lag"].forms[0].parameters[0].high * scales.of("T") * LEG.to_si["T"]
    assert nothing["drive_lag"] == {joint: f"more than {most:.2g} s" for joint in LEG.joints}
    assert not any("more than" in size for size in said["drive_lag"].values())


@pytest.mark.parametrize("rms, tried", [(0.18, False), (0.31, True)])
def test_a_gap_is_searched_from_a_quarter_of_the_noise_on(plain, monkeypatch, rms, tried):
    """All sensors show a slow tone, in units of their noise, that no name explains, and no difference of readings."""
    tone = np.sqrt(2.0) * rms * NOISE * np.ptp(plain.readings, axis=0) * np.sin(0.09 * plain.step * np.arange(len(plain)))[:, None]
    assert bool(searched(replace(plain, readings=plain.readings + tone), monkeypatch).tried) == tried


def test_no_more_counts_as_noise_than_the_readings_have(plain, monkeypatch):
    """What is left differs from sample to sample by a third more, in squares, than the noise that is known."""
    monkeypatch.setattr(search, "candidates", lambda *_: [FRICTION, *BESIDE])
    prepared = prepare(LEG, plain, noise=noise_of(plain.readings) / 1.15)
    assert prepared.base.left - noise_floor(prepared.weighed, prepared.base) < prepared.weighed.least
    assert gap_searched(prepared, lambda _: None).tried


def test_steps_of_a_sensor_that_look_like_noise_are_searched(plain, monkeypatch):
    """The swing's encoder knows 60 angles, several of which pass between two readings, and rounds none of its own."""
    readings = plain.readings.copy()
    step = np.ptp(readings[:, 0]) / 60.0
    readings[:, 0] = step * (np.round(readings[:, 0] / step) + 1e-4 * np.random.default_rng(0).standard_normal(len(plain)))
    state = searched(replace(plain, readings=readings), monkeypatch)
    assert state.base.left - noise_floor(state.weighed, state.base) < state.weighed.least
    assert ("sensor_quantisation", (0,)) in state.best.names


@pytest.mark.parametrize("off, verdict", [(0.18, "no_significant_gap"), (0.35, "parameters_only")])
def test_parameters_close_a_gap_only_where_there_is_one(plain, off, verdict):
    """Every sensor is off, for sure, in units of its noise."""
    bias = off * NOISE * np.ptp(plain.readings, axis=0)
    found = analyse(LEG, replace(plain, readings=plain.readings + bias))
    plainly = left_of(found.prepared.weighed, found.prepared.judged, found.prepared.weighed.model.plain)[1]
    assert better(plainly, found.prepared.base.blocks) > SIGNIFICANT
    assert found.verdict.verdict == verdict
