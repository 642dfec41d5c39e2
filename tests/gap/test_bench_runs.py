"""The benchmark's further runs of a hidden machine: with other noise, half as long, and under the drives that a verdict asks for."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from hamr_description.errors import ConfigError
from hamr_dynamics import machine_kernel
from hamr_gap.bench import ablate, alone
from hamr_gap.bench.cases import LEG, load, make, number
from hamr_gap.bench.other import file_of, measure_otherwise
from hamr_gap.bench.run import bench
from hamr_gap.bench.second import folder_of, measure_again
from hamr_gap.data.readings import noise_of
from hamr_gap.data.record import joined
from hamr_gap.fitting.scales import scales_of
from hamr_gap.legs import machine_of
from hamr_gap.naming import search, single_effects

NAME = number("null", "development", 0)  # nothing hidden, nothing changed


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    make(folder, "null", "development", 0, strength=5.0, seconds=2.0)
    return folder


def test_other_noise_is_all_that_differs_and_half_is_the_first_half(out):
    measure_otherwise(out, NAME)
    first, noise, half = load(out / "cases" / f"{NAME}.npz"), *(load(file_of(out, way, NAME)) for way in ("noise", "half"))
    assert np.array_equal(first.drives, noise.drives)
    apart = noise.readings - first.readings
    apart = apart[np.isfinite(apart).all(1)]  # where no end stop was hit
    assert np.allclose(apart.std(0), np.sqrt(2) * noise_of(first.readings), rtol=0.1)
    assert np.abs(np.corrcoef(apart[1:, 0], apart[:-1, 0])[0, 1]) < 0.05
    assert np.array_equal(half.readings, first.readings[: len(first) // 2], equal_nan=True)
    assert np.array_equal(half.drives, first.drives[: len(first.drives) // 2])


def test_a_case_that_nothing_solved_is_said_and_counts_for_nothing(out, tmp_path, capsys):
    shutil.copytree(out / "answers", tmp_path / "answers")
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / f"{NAME}.npz").write_text("no record")
    found = bench(tmp_path, nulls=1, workers=1)
    assert found["no verdict, not counted above"] == str(NAME)
    assert found["nulls: false alarms"] == found["processor seconds: median, 90th percentile"] == "-"
    assert f"{NAME}.json" in capsys.readouterr().err


def test_the_run_that_was_asked_for_is_that_of_the_same_machine(out):
    first = load(out / "cases" / f"{NAME}.npz")
    n = len(first) // 2
    time = first.step * np.arange(n)
    drives = np.stack([40.0 * np.sin(0.02 * time), 30.0 * np.sin(0.05 * time)], 1)
    (out / "verdicts").mkdir()
    np.savez(out / "verdicts" / f"{NAME}.npz", drives=np.repeat(drives, first.drives_per_reading, axis=0))
    measure_again(out, "verdicts", NAME)
    again = load(folder_of(out, "verdicts") / f"{NAME}.npz")
    assert len(joined([first, again])) == len(first) + n
    assert np.allclose(again.drives[:: first.drives_per_reading], drives, atol=1e-9)
    leg = machine_of("simple", LEG)
    run = machine_kernel.simulate(leg, again.fine(5), leg.neutral(scales_of(leg, again))[None], step=again.step / 5, substeps=5)[0]
    left = again.readings[100:] - run[100:n]
    assert np.all(left.std(0) < 1.5 * noise_of(again.readings))


def test_without_a_step_the_workflow_is_another_and_comes_back(monkeypatch, tmp_path):
    """The step is really out while a case is solved, and in again afterwards."""
    whole, seen = search.narrowed, []
    monkeypatch.setattr(ablate, "solve", lambda *_: seen.append((search.narrowed, single_effects.ALL_FORMS)))
    ablate.solve_without("fewer", tmp_path / "answer.json")
    ablate.solve_without("forms", tmp_path / "answer.json")
    assert seen[0][0] is not whole and seen[0][0](None, None, None) == []
    assert seen[1] == (whole, 0) and single_effects.ALL_FORMS > 0


@pytest.mark.parametrize("step", ablate.STEPS)
def test_every_step_that_can_be_left_out_is_there(step, monkeypatch, tmp_path):
    """Under the name by which the workflow calls it; left out, it is something else."""
    whole = [getattr(where, name) for where, name, _ in ablate.STEPS[step]]
    seen = []
    monkeypatch.setattr(ablate, "solve", lambda *_: seen.extend(getattr(where, name) for where, name, _ in ablate.STEPS[step]))
    ablate.solve_without(step, tmp_path / "answer.json")
    assert not any(np.array_equal(a, b) for a, b in zip(whole, seen, strict=True))


def test_seconds_are_of_an_analysis_after_a_first_one(out, monkeypatch, capsys, tmp_path):
    """Which may compile kernels."""
    clock = iter((0.0, 600.0, 600.0, 603.0))
    monkeypatch.setattr(alone, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(alone, "analyse", lambda machine, record: None)
    alone.main(out, cases=1)
    told = json.loads(capsys.readouterr().out)
    assert told["median"] == told["90th percentile"] == 3.0
    assert len(told["cases"]) == 1
    with pytest.raises(ConfigError, match="no case"):
        alone.main(tmp_path)
