"""What a hit on an actuator's end stop leaves in a leg, and for how long readings after one are left out."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_gap.data.record import Record, joined
from hamr_gap.judging.stated import poor
from hamr_gap.legs import NEAR_STOP, SHAKEN_MS, clear_of_stops, machine_of

CHANNELS = ("fl_swing", "fl_lift", "fl_swing_actuator", "fl_lift_actuator")
STEP = 0.25  # ms


def record(hits_ms: list[float], seconds: float = 12.0) -> Record:
    """Tips at rest, but for a sample at each hit in which the lift's is at its stop."""
    n = round(1e3 * seconds / STEP)
    readings = np.zeros((n, 4))
    readings[np.round(np.array(hits_ms) / STEP).astype(int), 3] = -value("actuator.stop")
    return Record(np.zeros((n, 2)), readings, STEP, CHANNELS)


def clear(x: Record) -> np.ndarray:
    """(n,) whether the readings of a sample count."""
    told = np.isfinite(x.readings)
    assert (told.all(1) == told.any(1)).all()
    return told.all(1)


@pytest.mark.parametrize("backend", ["simple", "full"])
@pytest.mark.parametrize("leg", LEGS)
def test_a_hit_has_rung_down_to_a_hundredth(backend, leg):
    at = machine_of(backend, leg).at_rest
    slowest = max(2.0 * at.mass[i] / at.damping[i] for i in (0, 2))
    assert np.exp(-SHAKEN_MS[0][0] / slowest) < 0.01


def test_readings_after_a_hit_are_left_out_for_as_long():
    found = clear(clear_of_stops(record([3000.0])))
    assert np.flatnonzero(~found).tolist() == list(range(12000, 12000 + round(480.0 / STEP)))


@pytest.mark.parametrize(("every", "ms"), [(2000.0, 480.0), (1000.0, 480.0), (700.0, 240.0), (400.0, 120.0), (160.0, 120.0), (130.0, 0.0)])
def test_frequent_hits_are_forgotten_sooner_rather_than_leave_little(every, ms):
    hits = np.arange(100.0, 11500.0, every)
    found = clear(clear_of_stops(record(hits.tolist())))
    assert (~found).sum() == len(hits) * round(ms / STEP)


def test_every_reading_stays_where_nothing_hits():
    assert clear(clear_of_stops(record([]))).all()


def test_what_was_left_out_is_said():
    """A stop near the leg's own, which no other reading shows, would pass for no gap."""
    hit, calm = clear_of_stops(record([3000.0], seconds=6.0)), clear_of_stops(record([], seconds=12.0))
    assert hit.shaken == pytest.approx(0.08) and calm.shaken == 0.0
    both = joined([hit, calm])
    assert both.shaken == pytest.approx(0.08 / 3.0)
    assert both.shaken == pytest.approx(np.isnan(both.readings).all(1).mean())
    (note,) = poor(SimpleNamespace(stale=0.0, weighed=SimpleNamespace(model=SimpleNamespace(record=hit))))
    assert note.startswith("8 % of the samples") and "not seen" in note


@pytest.mark.parametrize("leg", LEGS)
@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_hip_angles_tell_of_hits_where_tips_were_not_measured(leg, joint, side):
    machine, channels = machine_of("full", leg), (f"{leg}_swing", f"{leg}_lift")

    def beyond(q: float) -> float:
        """mm past the stop, of the whole geometry."""
        return side * machine.outputs(tuple(q * (i == joint) for i in (0, 1)), (0.0, 0.0))[2 + joint] - value("actuator.stop")

    told = []
    for share in (NEAR_STOP - 0.05, NEAR_STOP + 0.05):
        readings = np.zeros((4000, 2))
        readings[1000, joint] = share * brentq(beyond, 0.0, 0.8 * side)
        told.append(np.isfinite(clear_of_stops(Record(np.zeros((4000, 2)), readings, STEP, channels)).readings).all())
    assert told == [True, False]
