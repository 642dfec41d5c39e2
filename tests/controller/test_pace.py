"""Sim time against wall time, with a clock that moves by hand."""

from __future__ import annotations

import pytest

from hamr_controller.simulation import Pace


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_periods_are_due_at_even_distances(factor):
    clock = Clock()
    pace = Pace(factor, clock=clock)
    for _ in range(1000):
        clock.now += pace.remaining()
        pace.advance()
        clock.now += 0.0003  # the period's own work
    assert clock.now - 100.0 == pytest.approx(999 * 0.004 / factor, abs=0.001)
    assert pace.overruns == 0


def test_as_fast_as_possible_never_waits():
    pace = Pace(0.0, clock=Clock())
    pace.advance()
    assert pace.remaining() == 0.0 and pace.overruns == 0


def test_a_short_stall_is_made_up_a_long_one_is_given_up_and_counted():
    clock = Clock()
    pace = Pace(1.0, clock=clock)
    clock.now += 0.05
    pace.advance()
    assert pace.remaining() == 0.0 and pace.overruns == 0
    clock.now += 1.0
    pace.advance()
    assert pace.overruns == 1 and pace.remaining() == 0.0
    pace.advance()
    assert pace.remaining() == pytest.approx(0.004)


def test_time_that_stood_still_on_purpose_is_no_lag():
    clock = Clock()
    pace = Pace(1.0, clock=clock)
    clock.now += 60.0
    pace.resume()
    pace.advance()
    assert pace.overruns == 0 and pace.remaining() == pytest.approx(0.004)
