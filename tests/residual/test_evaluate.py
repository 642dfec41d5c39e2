"""The yardstick: a plant against itself has no error, a known difference gives the known error, stops are left out."""

from __future__ import annotations

import numpy as np
import pytest
from residual_samples import noise_run

from hamr_description.rates import SERVO_MS
from hamr_sim_residual import evaluate
from hamr_sim_residual.evaluate import Truth


@pytest.fixture(scope="module")
def run() -> Truth:
    return noise_run(3, 0.6, 30.0)


def test_full_against_itself(run):
    found = evaluate.errors("full", run, (0.25, 8.0, 100.0))
    assert found.finite
    np.testing.assert_allclose(found.mse[:, :2], 0.0, atol=1e-9)


def test_a_known_offset_is_found(run):
    shifted = Truth(run.q + 0.01, run.qd, run.qdd, run.volts, run.inside)
    # an offset in the truth's angle is there from the start: compare just after it
    found = evaluate.errors("full", shifted, (SERVO_MS,))
    assert found.mse[0, 0] < 1e-9  # the plant starts on the shifted state
    late = Truth(run.q.copy(), run.qd, run.qdd, run.volts, run.inside)
    late.q[::2] += 0.01  # starts are anywhere, one step later half of the samples are off
    assert evaluate.errors("full", late, (SERVO_MS,)).mse[0, 0] == pytest.approx(1e-4, rel=0.05)


def test_windows_that_touch_a_stop_are_left_out(run):
    inside = run.inside.copy()
    inside[:, 2] = False
    found = evaluate.errors("full", Truth(run.q, run.qd, run.qdd, run.volts, inside), (8.0,))
    whole = evaluate.errors("full", run, (8.0,))
    assert found.samples[0] == whole.samples[0] * 3 // 4  # the leg's other joint goes too


def test_table_gains_and_figure(run, tmp_path):
    rows = evaluate.table({"simple": "simple", "published": "simple_published"}, {"noise": run}, (0.25, 8.0))
    assert len(rows) == 2 * 2 * 3
    gained = evaluate.gains(rows, "simple")
    assert {row["plant"] for row in gained} == {"published"}
    assert all(row["gain"] < 1 for row in gained)
    assert evaluate.figure(rows, tmp_path / "figure.png").stat().st_size > 10_000


def test_effects_are_added_to_the_plant(run, tmp_path):
    """HAMR-full with stiffer hips strays from HAMR-full; without effects it does not."""
    file = tmp_path / "stiffer.yaml"
    file.write_text("effects: []\nchanges:\n  - {change: stiffness, joints: [all], value: 5.0e-5, unit: N*m/rad}\n")
    with_them, without = (evaluate.errors("full", run, (8.0,), effects=e).mse[0, 0] for e in (file, ""))
    assert without < 1e-9 < 1e-6 < with_them < run.q.var()
