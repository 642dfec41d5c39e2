"""What nothing drives, filmed: what takes its energy shows in long pieces only, whose starts are fitted with everything else."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hanging import hanging

from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record
from hamr_gap.fitting.continued import continued
from hamr_gap.fitting.fit import fit
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.fitting.roles import mask, roles_of
from hamr_gap.fitting.scales import scales_of
from hamr_gap.fitting.sensors import Sensors
from hamr_gap.fitting.settled import settled
from hamr_gap.fitting.tune import _begun, tune
from hamr_gap.judging.analyse import analyse
from hamr_gap.naming.candidates import candidates
from hamr_gap.naming.hypothesis import Start, left_of, refined
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.screen import screen

SQUARE, RATE, NOISE = 36.0, 60.0, 0.004  # (rad/s)^2, frames a second, m
UNITS = {"F": "N", "Q": "m", "T": "s", "U": "N"}


def oscillator(stiffness: float = SQUARE, damping: float = 0.05):
    return linear_machine("slider", inertia=1.0, damping=damping, stiffness=stiffness, joint="slider", units=UNITS)


@cache
def decaying(seconds: float = 40.0, *, friction: float = 0.0, drag: float = 0.0, damping: float = 0.03, noise: float = NOISE) -> Record:
    """Let go at 1 m; m/s^2 of dry friction, 1/m of drag, 1/s of damping, by small steps that know nothing of the library."""
    fine, q, v = 40, 1.0, 0.0
    h, seen = 1.0 / RATE / fine, np.empty(int(seconds * RATE))
    for i in range(len(seen)):
        seen[i] = q
        for _ in range(fine):
            v -= h * (SQUARE * q + damping * v + friction * math.tanh(v / 5e-3) + drag * v * abs(v))
            q += h * v
    seen += np.random.default_rng(0).normal(0.0, noise, len(seen))
    return Record(np.zeros((len(seen), 1)), seen[:, None], 1.0 / RATE, ("slider",), rest=False)


def long_model(record: Record, pieces: int = 2) -> Model:
    machine = oscillator()
    return Model(machine, record, 2, 1, scales_of(machine, record), piece=record.span / pieces, begins=True)


@pytest.mark.parametrize(
    ("what", "law", "size", "value"),
    [({"friction": 0.2}, "coulomb_friction", "level", 0.2), ({"drag": 0.03}, "quadratic_damping", "coefficient", 0.03)],
)
def test_what_slows_a_filmed_oscillator_down_is_named_in_its_size(what, law, size, value):
    """The given stiffness is off by a tenth: a re-tune has to find the frequency first."""
    verdict = analyse(oscillator(1.1 * SQUARE), decaying(**what)).verdict
    found = verdict.set[0].effects
    assert verdict.verdict == "named" and [e.effect for e in found] == [law]
    inertia = 1.0 + verdict.parameters["inertia"]["slider"].value  # only forces over it show in what nothing drives
    assert found[0].parameters[size]["slider"].value / inertia == pytest.approx(value, rel=0.1)


def test_an_oscillator_that_only_damps_lacks_nothing():
    assert analyse(oscillator(1.1 * SQUARE), decaying()).verdict.verdict == "parameters_only"


@pytest.mark.parametrize("off", [0.6, 1.5])
def test_a_frequency_that_is_far_off_is_found(off):
    """By more than half a period within a piece, where a fit from the model as given rests in another minimum."""
    tuned = tune(oscillator(off * SQUARE), decaying(), np.array([NOISE]))
    x = dict(zip((f.row for f in tuned.fit.free), tuned.fit.x * [f.scale for f in tuned.fit.free], strict=True))
    assert (off * SQUARE + x["change.stiffness.0"]) / (1.0 + x["change.inertia.0"]) == pytest.approx(SQUARE, rel=2e-3)
    assert tuned.rms[0] < 1.1 * NOISE and len(tuned.weighed.model.pieces) <= 2


def test_where_every_inertia_diverges_a_retune_begins_with_the_given_one(monkeypatch):
    """And nobody is warned of sums over nothing."""
    tuned = tune(oscillator(), decaying(), np.array([NOISE]))
    monkeypatch.setattr(Model, "runs", lambda self, free, x, *more: np.full((len(np.atleast_2d(x)), *self.target.shape), np.nan))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not _begun(tuned.weighed, list(tuned.fit.free)).any()
        assert np.isnan(tuned.weighed.missed(np.full_like(tuned.fit.reading, np.nan))).all()


def test_free_starts_move_the_starts_of_their_own_pieces():
    model = long_model(decaying())
    by = np.array([0.02, -0.01, 0.3, 0.1]).reshape(2, 2)  # of both pieces, coordinate and rate
    free = model.free_starts
    names = [f.row for f in free]
    assert names == ["start.0", "start.1", "start.2", "start.3"]
    moved = model.runs(free, by.ravel() / [f.scale for f in free])[0]
    other = replace(model)
    other.pieces = replace(model.pieces, start=model.pieces.start + by)
    assert np.array_equal(moved, other.run_rows(model.neutral[None])[0], equal_nan=True)
    assert not np.allclose(moved, model.plain, equal_nan=True)
    still = replace(model, begins=False)  # for which they are nothing
    assert still.free_starts == [] and np.array_equal(still.runs(free, by.ravel())[0], still.plain, equal_nan=True)


def test_a_swing_over_the_side_is_followed_and_its_friction_fitted_from_next_to_nothing():
    """A pendulum let go at 2.7 rad, whose period falls by half: long pieces drift, and fits from afar rest turns away in them."""
    inertia, weight, damping, friction, fine, q, v = 0.021, 0.639, 5e-4, 3.2e-3, 40, 2.7, 0.0
    h, seen = 1.0 / RATE / fine, np.empty(int(39 * RATE))
    for i in range(len(seen)):
        seen[i] = q
        for _ in range(fine):
            v -= h / inertia * (weight * math.sin(q) + damping * v + friction * math.tanh(v / 5e-3))
            q += h * v
    seen += np.random.default_rng(0).normal(0.0, 2e-3, len(seen))
    record = Record(np.zeros((len(seen), 1)), seen[:, None], 1.0 / RATE, ("arm",), rest=False)
    weighed, base = (prepared := prepare(hanging("swing", inertia=inertia, weight=weight, damping=1e-3), record)).weighed, prepared.base.fit
    assert len(weighed.model.pieces) == 2
    lengths, shorter = [], weighed
    while shorter:
        lengths.append(len(shorter.model.pieces))
        shorter = shorter.shorter
    assert lengths == [2, 4, 8, 16]
    law = Candidate("coulomb_friction", "sign", (0,))
    free = (*base.free, *(own := effect_parameters((law,), weighed.model.scales)))
    x = np.concatenate([base.x, [f.center or 1e-3 * f.sd for f in own]])
    direct, led = fit(weighed, free, x), continued(weighed, free, x)
    assert [f.row for f in led.free] == [f.row for f in free]
    assert led.cost < 0.2 * direct.cost
    level = dict(zip((f.row for f in free), led.x, strict=True))["coulomb_friction.sign.level.0"] * own[0].scale
    assert level == pytest.approx(friction, rel=0.05)
    start = Start((law,), free, x, np.inf)
    (found,) = refined(weighed, prepared.judged, [start])
    assert found.fit.cost == pytest.approx(led.cost)
    assert found.left < 1.2


def test_pieces_settle_where_they_began():
    record = decaying(10.0, damping=0.05, noise=1e-6)
    model = long_model(record)
    off = replace(model)
    off.pieces = replace(model.pieces, start=model.pieces.start + [[0.1, -0.3], [-0.05, 0.2]])
    alone = Sensors(np.zeros(1), np.zeros(1), 0.0)
    there = settled(off, model.neutral, np.array([1e-6]), alone)
    again = settled(model, model.neutral, np.array([1e-6]), alone)
    assert there.pieces.start == pytest.approx(again.pieces.start, abs=1e-6)
    assert there.pieces.start == pytest.approx(model.pieces.start, abs=0.02)  # which are measured
    left = [np.nanstd(m.target - m.run_rows(m.neutral[None])[0]) for m in (there, model)]
    assert left[0] < 0.6 * left[1]


@pytest.mark.parametrize("pieces", [1, 2, 4, 8])
def test_each_long_piece_has_every_role(pieces):
    model = long_model(decaying(), pieces)
    roles, parts = roles_of(model, 1.0), model.pieces.parts
    for start, stop in parts:
        shares = [getattr(roles, name)[start:stop].mean() for name in ("fit", "select", "calibrate", "report")]
        assert min(shares) > 0.05 and shares[0] == max(shares)
    assert sum(getattr(roles, name).sum() for name in ("fit", "select", "calibrate", "report")) > 0.75 * len(model.target)


def test_what_stands_still_is_no_evidence():
    """The oscillator has come to rest for the last three quarters: that both models leave no more than noise there is no news."""
    record = decaying(40.0, damping=0.8)
    prepared = prepare(oscillator(damping=0.8), record)
    weighed = prepared.weighed
    judged = mask(weighed.model, np.ones(len(weighed.model.target), bool))
    _, blocks = left_of(weighed, judged, weighed.model.plain)
    moving = int((np.abs(weighed.model.target[:, 0]) > 3 * NOISE).sum())
    assert 0 < len(blocks) <= 0.6 * 24 + 1 and moving < 0.5 * len(weighed.model.target)


def test_effects_are_screened_at_the_size_that_matters():
    """A typical drag stops an oscillator at once, and half of that too: sizes follow until responses are as large as they should be."""
    prepared = prepare(oscillator(1.1 * SQUARE), record := decaying(drag=0.03))
    weighed, wanted = prepared.weighed, 1.5
    drag = [c for c in candidates(weighed.model.machine, record) if c.effect == "quadratic_damping"]
    seen = screen(weighed, prepared.base.fit, drag, amplitude=wanted)
    gram, _, _ = seen.fitted
    rms = np.sqrt(gram[seen.fixed, seen.fixed] / weighed.chosen.sum())
    assert wanted / 2.0 <= rms <= wanted * 2.0
    assert seen.best(drag[0])[0].value[seen.fixed] > 0.0  # what a response far too large would turn round
