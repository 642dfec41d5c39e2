"""Tables whose rows were taken at uneven times, against signals that are known at every time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hamr_description.errors import BagError
from hamr_dynamics.machine import linear_machine
from hamr_gap import plants
from hamr_gap.data.clock import Clock
from hamr_gap.data.columns import record_of
from hamr_gap.data.record import Record, joined
from hamr_gap.fitting.pieces import pieces_of
from hamr_gap.judging.analyse import analyse

STEP = 0.01
MODEL = """
from hamr_dynamics.machine import linear_machine

def slide():
    return linear_machine("slide", inertia=1.0)
"""


def wave(time: np.ndarray) -> np.ndarray:
    """(n, 1), 5 Hz: twenty rows a period."""
    return np.sin(10 * np.pi * time)[:, None]


def jittered(n: int, share: float, seed: int = 0) -> np.ndarray:
    """(n,) times whose steps are longer and shorter than one by up to a share; what is lost is not caught up."""
    return np.cumsum(STEP * (1.0 + np.random.default_rng(seed).uniform(-share, share, n)))


def test_rows_are_read_at_even_times():
    time = jittered(2000, 0.2)
    clock = Clock.of(time, "here")
    assert clock.uneven == pytest.approx(0.2, abs=0.005) and clock.breaks == ()
    assert clock.step == pytest.approx(np.diff(time).mean(), rel=1e-12)
    held = np.where(time[:, None] % 1.0 < 0.5, 1.0, -1.0)
    drives, readings, breaks = clock.evened(held, wave(time))
    even = time[0] + clock.step * np.arange(len(readings))
    assert abs(len(even) - len(time)) <= 1 and even[-1] <= time[-1] and breaks == ()
    assert readings == pytest.approx(wave(even), abs=1e-3)  # the rows themselves are off by up to 0.3 there
    assert np.abs(drives).max() <= 1.0 and np.mean(np.abs(drives) == 1.0) > 0.95  # jumps of a drive stay jumps


def test_what_is_even_stays_as_it_is():
    time = np.r_[jittered(50, 0.009), 3.0 + jittered(30, 0.009)]
    clock, x = Clock.of(time, "here", 0.02), wave(time)
    drives, readings, breaks = clock.evened(x, x)
    assert drives is x and readings is x and breaks == clock.breaks == (50,)
    assert clock.uneven == 0.0 and clock.step == pytest.approx(STEP, rel=1e-2)


def test_breaks_and_missing_readings_stay_where_they_were():
    time = np.r_[jittered(100, 0.1), 5.0 + jittered(1, 0.1), 9.0 + jittered(60, 0.1, 1)]
    gone = (time > 0.301) & (time <= 0.5)
    x = np.where(gone[:, None], np.nan, wave(time))
    _, readings, breaks = Clock.of(time, "here", STEP).evened(wave(time), x)
    assert np.diff((0, *breaks, len(readings))) == pytest.approx([100, 1, 60], abs=1)
    first = time[0] + STEP * np.arange(breaks[0])
    before, after = time[time < 0.301][-1], time[time > 0.5][0]  # rows on either side of what is missing
    np.testing.assert_array_equal(np.isfinite(readings[: breaks[0], 0]), (first <= before) | (first >= after))
    np.testing.assert_allclose(readings[breaks[0]], wave(time[100:101])[0])
    last = time[101] + STEP * np.arange(len(readings) - breaks[1])
    assert readings[breaks[1] :] == pytest.approx(wave(last), abs=1e-3)


@pytest.mark.parametrize("time", [jittered(500, 0.3), np.array([0.0, 1.0, 5.0])])
def test_what_is_no_clock_is_refused(time):
    with pytest.raises(BagError, match="uneven by"):
        Clock.of(time, "here")


def test_tables_of_one_run_share_a_step(tmp_path, monkeypatch):
    """Of uneven clocks no two have the same mean."""
    monkeypatch.setattr(plants, "study", lambda machine, record, *_, **__: record)
    (tmp_path / "model.py").write_text(MODEL)
    for seed in (0, 1):
        time = jittered(500, 0.2, seed)
        np.savez(tmp_path / f"{seed}.npz", time=time, drive=wave(time)[:, 0], joint=wave(time)[:, 0])
    record = plants.run(f"{tmp_path}/model.py:slide", [tmp_path / "0.npz", tmp_path / "1.npz"], tmp_path)
    assert len(record.stretches) == 2 and 0.2 < record.uneven < 0.25
    for start, stop in record.stretches:
        first = jittered(500, 0.2, int(start > 0))[0]
        assert record.readings[start:stop] == pytest.approx(wave(first + record.step * np.arange(stop - start)), abs=2e-3)


def test_tables_whose_clocks_differ_a_little_share_a_step(tmp_path):
    """Each even by itself, but 0.03 % apart; at half the rate they are no tables of one run."""
    for name, step in (("one", STEP), ("two", 1.0003 * STEP), ("slow", 2.0 * STEP)):
        time = step * np.arange(2000)
        np.savez(tmp_path / f"{name}.npz", time=time, drive=wave(time)[:, 0], joint=wave(time)[:, 0])
    machine = linear_machine("slide", inertia=1.0)
    first = record_of(machine, tmp_path / "one.npz")
    second, slow = (record_of(machine, tmp_path / f"{name}.npz", step=first.step) for name in ("two", "slow"))
    both = joined([first, second])
    assert second.step == first.step == pytest.approx(STEP) and second.uneven == pytest.approx(3e-4)
    assert both.readings[2000:] == pytest.approx(wave(STEP * np.arange(len(both) - 2000)), abs=1e-3)
    with pytest.raises(BagError, match="same time step"):
        joined([first, slow])


def test_a_clock_that_stutters_at_its_start_is_used_from_where_it_runs():
    """Its first rows are stretches of a sample or two, of which no piece can be made."""
    time = np.r_[0.0, 0.017, 0.034, 0.044, 0.07 + STEP * np.arange(1500)]
    drive = wave(time)
    record = Record(drive, wave(time), STEP, ("joint",), rest=False, breaks=Clock.of(time, "here").breaks)
    pieces = pieces_of(linear_machine("slide", inertia=1.0), record, 1)
    assert pieces.first.min() >= 4 and (pieces.stop - pieces.first >= 40).all() and len(pieces) > 10
    with pytest.raises(BagError, match="At most 40 samples follow each other"):
        pieces_of(linear_machine("slide", inertia=1.0), replace(record, breaks=tuple(range(40, 1504, 40))), 1)


def test_a_drive_must_be_known_at_uneven_times_too(tmp_path):
    time = jittered(50, 0.1)
    drive = np.where(np.arange(50) == 20, np.nan, 1.0)
    np.savez(tmp_path / "a.npz", time=time, drive=drive, joint=wave(time)[:, 0])
    with pytest.raises(BagError, match="drive is NaN"):
        record_of(linear_machine("slide", inertia=1.0), tmp_path / "a.npz")


def test_a_machine_that_lacks_nothing_lacks_nothing_where_times_are_uneven(tmp_path):
    """A spring, a mass and a damper in closed form, read at times uneven by 15 %, in two tables.

    What is left is what the readings at even times really miss of it, less than the rows did: between two rows noise is averaged.
    """
    slide = linear_machine("slide", inertia=1.0, stiffness=400.0, damping=4.0, joint="slide")
    omega = 2 * np.pi * np.array([0.7, 1.9, 2.9, 4.3])
    size = 100.0 / (400.0 - omega**2 + 4.0j * omega)
    records, missed = [], []
    for k, phases in enumerate(np.random.default_rng(3).uniform(0, 2 * np.pi, (2, 4))):

        def turning(time: np.ndarray, phases: np.ndarray = phases) -> np.ndarray:
            return np.exp(1j * (np.outer(time, omega) + phases))

        time = jittered(3000, 0.15, seed=k)
        noise = 1e-3 * np.random.default_rng(k).standard_normal(len(time))
        slid = (turning(time) * size).real.sum(1)
        np.savez(tmp_path / f"{k}.npz", time=time, drive=100.0 * turning(time).real.sum(1), slide=slid + noise)
        records.append(record_of(slide, tmp_path / f"{k}.npz", step=records[0].step if records else None))
        even = time[0] + records[-1].step * np.arange(len(records[-1]))
        missed.append(records[-1].readings[:, 0] - (turning(even) * size).real.sum(1))
    verdict = analyse(slide, joined(records)).verdict
    left = float(np.sqrt(np.mean(np.square(np.concatenate(missed)))))
    assert verdict.verdict == "no_significant_gap" and 0.9e-3 < left < 1e-3
    assert verdict.gap.per_channel["slide"]["retuned"] == pytest.approx(left, rel=0.03)
    assert any("uneven by up to 15 %" in note for note in verdict.notes)
