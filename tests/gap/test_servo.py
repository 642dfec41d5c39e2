"""A servo as people log it: gears that stick under load, an encoder of 4096 counts, a clock that is some per cent uneven.

Its friction is that of Duclusaud et al. (Extended friction models for the physics simulation of servo actuators, ICRA 2025): it grows
with the load of the gears and near standstill. A model without it is lost within seconds, and about a run that is lost nothing is linear.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hamr_dynamics.machine import Machine, Terms
from hamr_dynamics.scalar import cos, sin
from hamr_gap.data.columns import record_of
from hamr_gap.data.readings import sensor_noise
from hamr_gap.data.record import joined
from hamr_gap.fitting import tune as tune_module
from hamr_gap.fitting.pieces import moving
from hamr_gap.judging.analyse import analyse
from hamr_gap.naming import single_effects
from hamr_gap.naming import sought as sought_module
from hamr_gap.naming.candidates import candidates
from hamr_gap.naming.hypothesis import Start
from hamr_gap.naming.moves import look
from hamr_gap.naming.prepare import prepare

INERTIA, WEIGHT, DAMPING, GAIN = 0.0067, 0.48, 0.04, 0.096  # kg m^2, N m at a right angle, N m s, N m/V
COUNT, STEP, VOLTS, SPEED = 2.0 * math.pi / 4096, 5.3e-3, 7.4, 0.3  # rad, s, V, rad/s


def servo() -> Machine:
    """As a data sheet has it: inertia, damping and gain some per cent off, and no dry friction."""
    inertia, damping, gain = 0.0075, 0.035, 0.1

    def terms(q, v_mid, v, u) -> Terms:
        force = gain * u[0] - WEIGHT * sin(q[0]) - damping * v[0]
        return Terms((inertia,), (0.0,), (force,), (WEIGHT * cos(q[0]),), (damping,), (gain * u[0],))

    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "V"}
    return Machine("servo", ("arm",), ("arm",), terms, lambda q, slip: (q[0],), units, dict.fromkeys("FQTU", 1.0))


def sweep(time: float) -> float:
    return math.sin(time * time)


def sines(time: float) -> float:
    return math.sin(time) + 0.8 * math.sin(5.0 * time)


def logged(path, goal, *, level: float, share: float, boost: float, gain: float = 17.0, seconds: float = 6.0, seed: int = 1):
    """Table of so many V/rad towards a goal, by steps of 0.1 ms that know when the arm sticks, of no library.

    Args:
        level, share, boost: friction is (level + share |drive|) (1 + boost / (1 + (rate / 0.3)^2)), N m.
    """
    random, q, v, time, rows = np.random.default_rng(seed), 0.0, 0.0, 0.0, []
    while time < seconds:
        seen = round(q / COUNT) * COUNT
        volts = max(-VOLTS, min(VOLTS, gain * (goal(time) - seen)))
        rows.append((time, volts, seen))
        step = STEP * (1.0 + min(0.12, max(-0.12, 0.04 * random.standard_normal())))
        for _ in range(50):
            friction = (level + share * abs(GAIN * volts)) * (1.0 + boost / (1.0 + (v / SPEED) ** 2))
            free = v + step / 50 * (GAIN * volts - WEIGHT * math.sin(q) - DAMPING * v) / INERTIA
            v = math.copysign(max(abs(free) - step / 50 * friction / INERTIA, 0.0), free)
            q += step / 50 * v
        time += step
    np.savetxt(path, rows, delimiter=",", header="time,drive,arm", comments="")
    return path


def test_rounding_is_noise_even_where_evened_readings_hide_it(tmp_path):
    """An arm that stands still most of the time shows no noise between its counts; splines through them are no multiples of one."""
    record = record_of(servo(), logged(tmp_path / "log.csv", sweep, level=0.2, share=0.2, boost=1.0))
    assert record.uneven > 0.05
    assert sensor_noise(record) == pytest.approx([COUNT / math.sqrt(12.0)], rel=0.01)
    assert joined([record, replace(record, rounding=(1.0,))]).rounding == (1.0,)


def test_a_piece_starts_as_fast_as_the_arm_moves_between_two_counts(tmp_path):
    """A ramp that takes six samples for each count: whoever takes them for free of noise sees a staircase."""
    time = np.cumsum(STEP * (1.0 + 0.04 * np.random.default_rng(0).standard_normal(1200).clip(-3.0, 3.0)))
    rows = np.stack([time - time[0], np.sin(time), np.round(0.05 * time / COUNT) * COUNT], 1)
    np.savetxt(tmp_path / "ramp.csv", rows, delimiter=",", header="time,drive,arm", comments="")
    machine = servo()
    rate = moving(machine, record_of(machine, tmp_path / "ramp.csv"), np.arange(250, 1000, 25))[:, 1]
    assert rate == pytest.approx(np.full(30, 0.05), rel=0.01)


@pytest.mark.parametrize("lost", [True, False])
def test_names_that_short_pieces_like_are_fitted_where_the_free_run_is_lost(tmp_path, monkeypatch, lost):
    machine = servo()
    record = record_of(machine, logged(tmp_path / "log.csv", sweep, gain=8.5, level=0.01, share=0.15, boost=1.0))
    prepared, everything = prepare(machine, record), candidates(machine, record)
    weighed, base = prepared.weighed, prepared.base
    used = weighed.chosen | prepared.judged
    off = np.sqrt(np.nanmean(np.where(used, weighed.left(base.fit.reading), np.nan) ** 2)) * weighed.sigma / np.nanstd(weighed.model.target)
    monkeypatch.setattr(single_effects, "LOST", float(off[0]) * (0.99 if lost else 1.01))
    seen = look(weighed, base.fit, everything)
    _, wanted = single_effects.single_starts(weighed, prepared.judged, base, seen, everything)
    twice = [effects for effects, times in Counter(start.effects for start in wanted).items() if times > 1]
    assert bool(twice) == lost


def test_short_pieces_lead_fits_of_several_records_as_of_one(tmp_path, monkeypatch):
    machine, friction = servo(), {"level": 0.02, "share": 0.25, "boost": 0.0}
    first = record_of(machine, logged(tmp_path / "first.csv", sweep, **friction))
    second = record_of(machine, logged(tmp_path / "second.csv", sines, **friction), step=first.step)
    led, real = [], tune_module._led_by_pieces
    monkeypatch.setattr(tune_module, "_led_by_pieces", lambda tuned: (led.append(tuned), real(tuned))[1])
    prepared = prepare(machine, joined([first, second]))
    assert len(led) == 1  # the re-tune
    weighed, base = prepared.weighed, prepared.base
    assert len(weighed.model.pieces) == 2 and not weighed.model.starts
    monkeypatch.setattr(sought_module, "_led", lambda weighed, judged, found, fitted: (led.extend(found), [])[1])
    bare = Start((), base.fit.free, base.fit.x, base.fit.cost)
    sought_module.sought(weighed, prepared.judged, [bare])
    assert led[1:] == [bare]


def test_a_short_piece_is_no_longer_than_a_share_of_the_record(tmp_path):
    """The arm swings at 1.3 Hz; four periods of that are half of the record, and as lost as all of it."""
    machine = servo()
    record = record_of(machine, logged(tmp_path / "log.csv", sweep, level=0.02, share=0.25, boost=0.0))
    weighed = prepare(machine, record).weighed
    assert not weighed.model.starts
    pieces = weighed.in_pieces.model.pieces
    assert np.max(pieces.stop - pieces.first) * STEP < record.span / 25


@pytest.mark.parametrize(
    ("goal", "friction", "form"),
    [
        (sweep, {"level": 0.01, "share": 0.15, "boost": 1.0}, ("stribeck_friction", "loaded")),
        (sines, {"level": 0.02, "share": 0.25, "boost": 0.0}, ("coulomb_friction", "loaded")),
    ],
)
def test_gears_that_stick_under_load_are_named(tmp_path, goal, friction, form):
    """Six seconds each."""
    verdict = analyse(servo(), record_of(servo(), logged(tmp_path / "log.csv", goal, **friction))).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert (effect.effect, effect.form) == form
    assert effect.parameters["share"]["arm"].value == pytest.approx(friction["share"], rel=0.25)
