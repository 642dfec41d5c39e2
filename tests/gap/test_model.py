"""Readings that are late: what they show is the machine's state so much before, from its release from rest on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hamr_dynamics import machine_kernel
from hamr_gap.data.record import Record
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import changes
from hamr_gap.fitting.scales import scales_of
from hamr_gap.legs import machine_of

LEG = machine_of("simple", "fl")
SUBSTEPS, MEAN = 2, 5


STEP = 0.2  # ms


@pytest.fixture(scope="module")
def record() -> Record:
    """1.2 s at 5 kHz of a driven leg; what it read matters to nothing here but where pieces start."""
    time = STEP * np.arange(6000)[:, None]
    drives = 50.0 * np.sin(time * [0.11, 0.17] + np.sin(0.03 * time))
    readings = np.random.default_rng(1).standard_normal((len(drives), len(LEG.channels))).cumsum(0)
    return Record(drives, 1e-3 * readings, STEP, LEG.channels, held=True)


@pytest.fixture(scope="module")
def preloaded(record):
    """Parameters of a leg that moves as soon as it is let go."""
    free = changes(LEG, scales_of(LEG, record), record.driven)
    return free, np.array([0.3 if "preload" in f.row else 0.1 for f in free])


def states(model: Model, rows: np.ndarray) -> np.ndarray:
    """(steps, channels) readings at every step, on time, by the compiled loop itself."""
    step = model.record.step / SUBSTEPS
    return machine_kernel.simulate(LEG, model.record.fine(SUBSTEPS), rows, step=step, substeps=1)[0]


@pytest.mark.parametrize("late", [-13, -3, 3, 10, 24])
def test_a_late_run_is_the_run_before_to_the_bit(record, preloaded, late):
    model = Model(LEG, record, SUBSTEPS, MEAN, scales_of(LEG, record), delay=(late + 0.3) * record.step / SUBSTEPS)
    assert model.delay == pytest.approx(late * record.step / SUBSTEPS)  # whole steps; the rest is the sensors'
    fine = states(model, model.rows(*preloaded))
    at = np.arange(len(model.target))[:, None] * MEAN * SUBSTEPS + np.arange(MEAN) * SUBSTEPS - late
    known = (at.min(1) >= 0) & (at.max(1) < len(fine))
    assert np.array_equal(known, np.isfinite(model.target).all(1)) if late > 0 else known[0]
    np.testing.assert_allclose(model.runs(*preloaded)[0][known], fine[at[known]].mean(1), rtol=1e-12, atol=1e-15)
    short = model.runs(*preloaded, 100)[0]
    np.testing.assert_array_equal(short, model.runs(*preloaded)[0][:100])


@pytest.mark.parametrize("samples", [-2, 3])
def test_a_late_piece_is_driven_by_what_was_before(record, preloaded, samples):
    """As a piece on time whose drives somebody has moved by hand."""
    made = {"piece": 40 * MEAN * STEP, "scales": scales_of(LEG, record), "substeps": SUBSTEPS, "mean": MEAN}
    unknown = replace(record, rest=False)
    late = Model(LEG, unknown, delay=samples * STEP, **made)
    by_hand = Model(LEG, replace(unknown, drives=np.roll(record.drives, samples, axis=0)), **made)
    rows, inner = late.rows(*preloaded), slice(late.pieces.first[1], late.pieces.first[-1])
    runs = [model.run_rows(rows)[0, inner] for model in (late, by_hand)]
    assert np.ptp(runs[0]) > 0.0
    np.testing.assert_allclose(*runs, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("piece", [0.0, 40 * MEAN * STEP])
def test_a_run_is_read_as_the_record_is(record, preloaded, piece):
    """Free or in pieces: its channels, in its order, though the machine has others too."""
    made = {"piece": piece, "scales": scales_of(LEG, record), "substeps": SUBSTEPS, "mean": MEAN}
    every = replace(record, rest=not piece)
    turned = Model(LEG, replace(every, readings=record.readings[:, ::-1], channels=LEG.channels[::-1]), **made)
    few = Model(LEG, replace(every, readings=record.readings[:, 1::-1], channels=LEG.channels[1::-1]), **made)
    run = Model(LEG, every, **made).runs(*preloaded)[0]
    assert np.ptp(run, axis=0).min() > 0.0
    np.testing.assert_array_equal(turned.runs(*preloaded)[0], run[:, ::-1])
    np.testing.assert_array_equal(few.runs(*preloaded)[0], run[:, 1::-1])


@pytest.mark.parametrize("delay", [-1e6, 1e6])
def test_clocks_are_never_so_late_that_nothing_is_left(record, preloaded, delay):
    model = Model(LEG, record, SUBSTEPS, MEAN, scales_of(LEG, record), delay=delay)
    assert abs(model.delay) == pytest.approx(0.1 * len(record) * STEP)
    assert np.isfinite(model.runs(*preloaded)).all()
    assert np.isfinite(model.target).all(1).mean() >= 0.9 - 1e-9
