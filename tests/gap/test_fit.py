"""Fits in coarse steps, with what fine ones add to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hamr_dynamics import machine_kernel
from hamr_gap.fitting.corrected import Corrected
from hamr_gap.fitting.descent import KEPT, TRIALS, descend
from hamr_gap.fitting.fit import Fit, begun, ended, fit
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import Candidate
from hamr_gap.fitting.weighed import Weighed
from hamr_gap.flagship_find import recorded
from hamr_gap.legs import machine_of
from hamr_gap.naming.hypothesis import Start, left_of
from hamr_gap.naming.moves import look, singles
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.screen import Screen

FINE = 4  # times as many steps


@pytest.fixture(scope="module")
def swinging() -> tuple[Weighed, tuple]:
    """Two seconds of HAMR-full in steps of HAMR-simple's own and in finer ones, and what a re-tune frees."""
    prepared = prepare(machine_of("simple", "fl"), recorded("fl", seconds=2.0, noise=1e-3, seed=1))
    coarse = prepared.weighed.coarse
    fine = replace(coarse, substeps=FINE * coarse.substeps)
    return replace(prepared.weighed, model=fine, coarse=coarse), prepared.base.fit.free


def test_what_fine_steps_add_is_known_near_by(swinging):
    weighed, free = swinging
    x = np.zeros(len(free))
    run = weighed.model.runs(free, x)[0]
    runs = Corrected(weighed, free, x, run)
    assert not runs.exact
    np.testing.assert_allclose(runs.near(x[None])[0], run, rtol=1e-12, atol=1e-15)
    beside = x + np.array([[1e-4], [1e-3]])
    exact, coarse, near = (make(beside) for make in (
        lambda x: weighed.model.runs(free, x), lambda x: weighed.coarse.runs(free, x), runs.near))  # fmt: skip
    off = np.std(near - exact, axis=(1, 2))
    assert off[1] < 0.5 * np.std(coarse[1] - exact[1])
    assert off[0] < 0.2 * off[1]
    np.testing.assert_allclose(runs.at(beside[1], near[1]), exact[1], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(runs.near(beside)[1], exact[1], rtol=1e-12, atol=1e-15)  # about there from now on
    runs.refine()
    assert runs.exact
    np.testing.assert_array_equal(runs.near(x[None])[0], run)


def test_without_coarser_steps_all_runs_are_exact(swinging, monkeypatch):
    weighed, free = swinging
    x = np.zeros(len(free))
    run = weighed.model.runs(free, x)[0]
    for same in (None, weighed.model):
        assert Corrected(replace(weighed, coarse=same), free, x, run).exact
    monkeypatch.setattr(weighed.coarse, "runs", lambda free, x, samples: np.full((1, *run.shape), np.nan))
    assert Corrected(weighed, free, x, run).exact  # where coarse steps diverge


@pytest.fixture
def steps(monkeypatch) -> list[int]:
    """Steps of all lanes that are simulated, added to the last number."""
    counts = []
    run_rows = Model.run_rows

    def counted(model: Model, rows: np.ndarray, samples: int | None = None) -> np.ndarray:
        counts[-1] += len(rows) * model.substeps
        return run_rows(model, rows, samples)

    monkeypatch.setattr(Model, "run_rows", counted)
    return counts


def test_where_derivatives_keep_their_promise_no_other_steps_are_tried(swinging, steps, monkeypatch):
    weighed, free = swinging
    found = []
    for kept in (KEPT, np.inf):
        monkeypatch.setattr("hamr_gap.fitting.descent.KEPT", kept)
        steps.append(0)
        found.append(fit(replace(weighed, coarse=None), free, np.zeros(len(free))))
    assert found[0].cost == pytest.approx(found[1].cost, rel=1e-3)
    assert steps[0] < 0.8 * steps[1]


def test_where_derivatives_promise_nothing_no_step_is_tried(swinging, steps):
    """A fit that begins where another ended runs its start, its end, derivatives of each step and the first trials of all but the last."""
    weighed, free = swinging
    fine = replace(weighed, coarse=None)
    steps.append(0)
    end = fit(fine, free, np.zeros(len(free)))
    steps.append(0)
    again = descend(fine, begun(fine, free, end.x))
    ended(fine, again)
    trials = sum(len(some) for some in TRIALS[0])
    assert steps[1] == (2 + again.steps * len(free) + (again.steps - 1) * trials) * weighed.model.substeps


def test_a_fit_ends_where_one_in_fine_steps_ends_and_simulates_less(swinging, steps):
    weighed, free = swinging
    found = [(steps.append(0), fit(replace(weighed, coarse=coarse), free, np.zeros(len(free))))[1] for coarse in (weighed.coarse, None)]
    assert found[0].cost == pytest.approx(found[1].cost, rel=1e-4)
    assert steps[0] < 0.5 * steps[1]
    # cost and run are those of fine steps
    np.testing.assert_array_equal(found[0].run, weighed.model.runs(free, found[0].x)[0])


def test_coarse_steps_that_mislead_are_left(swinging):
    """Those of another machine: what they add does hang on the parameters."""
    weighed, free = swinging
    other = replace(weighed.coarse, machine=machine_of("full", "fl"))
    found = [fit(replace(weighed, coarse=coarse), free, np.zeros(len(free))).cost for coarse in (other, None)]
    assert found[0] == pytest.approx(found[1], rel=0.01)


def test_pieces_in_which_nothing_counts_are_not_run_and_change_nothing(swinging, monkeypatch):
    """To the bit, whether something is fitted, screened or begun; what a fit hands on is run whole."""
    weighed, free = swinging
    short, wanted, lanes = weighed.in_pieces, [Candidate("cubic_stiffness", "cubic", (0, 1))], []
    simulate = machine_kernel.simulate

    def counted(machine, drives, rows, **how):
        lanes[-1] += len(rows)
        return simulate(machine, drives, rows, **how)

    monkeypatch.setattr(machine_kernel, "simulate", counted)

    def made() -> tuple[Fit, Screen, list[Start], np.ndarray]:
        lanes.append(0)
        found = fit(short, free, np.full(len(free), 0.01))
        lanes.append(0)
        seen = look(short, found, wanted)
        lanes.append(0)
        return found, seen, singles(short, found, seen, wanted), np.array(lanes[-3:])

    few = made()
    monkeypatch.setattr(Weighed, "fitted", property(lambda weighed: weighed))
    every = made()
    assert (few[-1] < 0.5 * every[-1]).all()
    assert few[0].cost == every[0].cost
    np.testing.assert_array_equal(few[0].x, every[0].x)
    np.testing.assert_array_equal(few[0].reading, every[0].reading)
    for own, other in zip(few[1].fitted, every[1].fitted, strict=True):
        np.testing.assert_array_equal(own, other)
    assert [start.cost for start in few[2]] == [start.cost for start in every[2]]


def test_a_run_of_which_nothing_is_left_in_a_double_costs_more_than_any(swinging, monkeypatch):
    """A trial of 4e33 rad ended an analysis: beside it no prior counts, and bias, gain and lateness of a sensor look the same."""
    weighed, free = swinging
    run = weighed.model.runs(free, np.zeros(len(free)), weighed.until)[0]
    monkeypatch.setattr(np.linalg, "solve", lambda *_: np.linalg.inv(np.zeros((2, 2))))  # "Singular matrix"
    s, left = weighed.solve_sensors(run)
    assert left == np.inf
    assert s.tolist() == [0.0] * len(weighed.sensor_precision)


def test_a_fit_begins_nearer_where_a_start_leaves_nothing_in_a_double(swinging, monkeypatch):
    weighed, free = swinging
    solve = Weighed.solve_sensors
    x, asked = np.array([0.4 * f.sd for f in free]), []

    def far(self, run, *about, **how):
        asked.append(run)
        return (np.zeros(len(self.sensor_precision)), np.inf) if len(asked) <= 2 else solve(self, run, *about, **how)

    monkeypatch.setattr(Weighed, "solve_sensors", far)
    center = np.array([f.center for f in free])
    np.testing.assert_allclose(begun(weighed, free, x).x, center + 0.5 * (x - center))


def test_what_diverges_where_nothing_is_fitted_is_no_hypothesis(swinging):
    weighed, free = swinging
    judged = ~weighed.chosen & np.isfinite(weighed.model.target)
    found = fit(weighed, free, np.zeros(len(free)), steps=0)
    assert np.isfinite(left_of(weighed, judged, found.reading)[0])
    lost = np.where(np.arange(len(judged))[:, None] == np.flatnonzero(judged.any(1))[0], np.nan, found.reading)
    left, blocks = left_of(weighed, judged, lost)
    assert left == np.inf
    assert np.isinf(blocks).sum() == 1
