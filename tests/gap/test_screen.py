"""The linear picture: sizes at which responses are taken, and what they say of others."""

from __future__ import annotations

import numpy as np
import pytest
from shaken_leg import BESIDE, FRICTION

from hamr_dynamics.effects.library import find
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import Candidate
from hamr_gap.naming.moves import look
from hamr_gap.naming.screen import Column, Screen, screen


def test_a_threshold_is_where_the_line_through_the_first_responses_meets_zero():
    """Of sizes of which the first two do nothing; one without a threshold does as much as it is large, and a dip counts as level."""
    (limit,), (square,) = (find(*name).sizes for name in (("drive_saturation", "hard"), ("quadratic_damping", "square")))
    sizes, rms = (0.4, 0.45, 0.5, 0.56), np.array([0.0, 0.0, 1.0, 7.0, 3.0])
    columns = [*(Column("limit", limit, size, ()) for size in sizes), Column("square", square, 0.2, ())]
    seen = Screen(columns, 0, {}, (np.diag(rms**2), None, 0.0), np.zeros(5), 1.0)
    assert [seen.size_of(2, share) for share in (0.0, 0.5, 1.0, 4.0)] == pytest.approx([0.49, 0.495, 0.5, 0.53])
    assert seen.size_of(3, 1 / 7) == pytest.approx(0.5)
    assert seen.size_of(4, 0.5) == 0.1
    dipping = Screen(columns, 0, {}, (np.diag(np.square([3.0, 5.0, 4.0, 6.0, 3.0])), None, 0.0), np.zeros(5), 1.0)
    assert dipping.size_of(2, 0.9) == pytest.approx(0.43)


def test_responses_that_diverge_are_no_columns(rubbing, monkeypatch):
    """Neither of sizes that were tried smaller in vain, nor of limits that keep theirs."""
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda *given: (run := real(*given)) * np.where(len(run) > 1, 1e30, 1.0))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, Candidate("drive_saturation", "hard", (1,))])
    own = np.diag(seen.fitted[0])[seen.fixed :]
    assert len(own) > 1
    np.testing.assert_array_equal(own, 0.0)


def test_responses_of_about_the_size_wanted_serve_as_they_are(rubbing, monkeypatch):
    """What is far from it is simulated again, at another size; limits that are screened one by one keep theirs."""
    simulated = []
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda model, rows, *more: (simulated.append(rows), real(model, rows, *more))[1])
    clipped = Candidate("drive_saturation", "hard", (1,))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, *BESIDE, clipped])
    rows, index = np.concatenate(simulated), rubbing.weighed.model.machine.parameter_rows.index
    resized = [c for c in seen.columns if c.size != c.parameter.typical and not c.parameter.screen]
    assert 0 < len(resized) < len([c for c in seen.columns if not c.parameter.screen])
    for row in {c.row for c in seen.columns}:
        own = [c for c in seen.columns if c.row == row]
        assert np.count_nonzero(rows[:, index(row)]) == len(own) + len([c for c in own if c in resized])


def test_sizes_of_another_picture_serve_about_another_fit(rubbing, monkeypatch):
    """In proportion to what is to be explained: fewer are simulated twice, at sizes about as large."""
    wanted = [FRICTION, *BESIDE, Candidate("drive_saturation", "hard", (1,))]
    first = look(rubbing.weighed, rubbing.base.fit, wanted)
    simulated = []
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda model, rows, *more: (simulated.append(len(rows)), real(model, rows, *more))[1])
    amplitude = 0.1 * first.amplitude
    fresh = screen(rubbing.weighed, rubbing.base.fit, wanted, amplitude=amplitude)
    lanes = sum(simulated)
    again = screen(rubbing.weighed, rubbing.base.fit, wanted, amplitude=amplitude, before=first)
    assert lanes > sum(simulated) - lanes >= len(again.columns)
    assert [(c.row, c.shapes) for c in again.columns] == [(c.row, c.shapes) for c in fresh.columns]
    for own, other in zip(fresh.columns, again.columns, strict=True):
        assert own.size == other.size if own.parameter.screen else 0.25 < own.size / other.size < 4.0
    assert again.amplitude == amplitude


@pytest.mark.filterwarnings("error")
def test_laws_that_move_far_too_much_are_seen_at_smaller_sizes(rubbing, monkeypatch):
    """Without a warning, where the square of what they move is beyond single precision."""
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda *given: 1e22 * real(*given))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, Candidate("quadratic_damping", "square", (1,))])
    assert [c.size for c in seen.columns] == pytest.approx([1e-3 * c.parameter.typical for c in seen.columns])
