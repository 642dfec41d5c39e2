"""`hamr reproduce` measures what it prints, and calls things by the name it was given."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from hamr_bringup import reproduce as figures
from hamr_bringup.cli import run


def test_the_error_of_the_shipped_residual_is_measured_and_drawn(tmp_path, monkeypatch, capfd):
    """On short runs: orders of magnitude below HAMR-simple's, and the lumped fit of other hip angles far above it."""
    monkeypatch.setattr(figures, "NOISE_S", 0.3)
    monkeypatch.setattr(figures, "TROT_S", 0.1)
    monkeypatch.setattr(figures, "HORIZONS_MS", (0.25, 8.0))
    assert run(["reproduce", "residual", "--out", str(tmp_path / "figures"), "--json"]) == 0
    rows = json.loads(capfd.readouterr().out)["rows"]
    assert len(rows) == 2 * 2 * 2 * 2  # plants, runs, quantities, horizons
    for row in rows:
        assert row["figure"] == "residual"
        if row["name"].startswith("residual"):
            assert row["agrees"] is True and row["value"] > 1000
        else:
            assert row["agrees"] is None and row["value"] < 1
    assert (tmp_path / "figures" / "residual.png").stat().st_size > 10_000


def test_a_residual_is_learned_from_data_of_its_own(monkeypatch, capfd):
    """From one second in place of twelve: it beats HAMR-simple by far, and is not the shipped one."""
    monkeypatch.setattr(figures, "SECONDS", 1.0)
    monkeypatch.setattr(figures, "NOISE_S", 0.3)
    monkeypatch.setattr(figures, "HORIZONS_MS", (8.0,))
    assert run(["reproduce", "data", "--json"]) == 0
    length, *gains = json.loads(capfd.readouterr().out)["rows"]
    assert length["value"] == pytest.approx(1.0) and length["agrees"] is True
    assert [row["value"] > 1000 and "do not equal" in row["note"] for row in gains] == [True, True]


@pytest.mark.parametrize("words", [["reproduce", "residuals"], ["reproduce", "policies", "barchart"]])
def test_an_unknown_figure_is_one_sentence(words):
    done = subprocess.run([sys.executable, "-m", "hamr_bringup.cli", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr.strip() == f"hamr: reproduce: There is no figure '{words[-1]}': choose from data, residual, policies, speed."
