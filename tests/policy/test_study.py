"""The study trains what is missing, once, and its tables say what the robots did."""

from __future__ import annotations

import pytest

from hamr_description.errors import ConfigError
from hamr_policy import study
from hamr_policy.evaluate import evaluate


def test_the_study_trains_once_and_tabulates_what_evaluation_finds(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("hamr_policy.evaluate.ENDURANCE_S", 0.4)
    study.main(tmp_path, ("simple",), seeds=2, steps=2048)
    first = capsys.readouterr().out
    monkeypatch.setattr(study, "train", None)  # whoever trains now, fails
    study.main(tmp_path, ("simple",), seeds=2, steps=2048)
    assert capsys.readouterr().out == first
    rows = evaluate([tmp_path / f"turn_simple_{seed}" / "policy.onnx" for seed in range(2)])["rows"]
    left = next(row for row in rows if (row["direction"], row["run_on"], row["quantity"]) == ("left", "full", "turning_rate"))
    each = ", ".join(f"{float(f'{x:.3g}'):g}" for x in left["by_seed"])
    assert f"{each} | 537 | NO |" in next(line for line in first.splitlines() if line.startswith("| left, deg/s"))
    assert "| simple | 2 |" in first and "4.62 +- 1.6" in first


def test_an_unknown_training_is_named(tmp_path):
    with pytest.raises(ConfigError, match="'simpel'"):
        study.study(tmp_path, ["simpel"], seeds=1, steps=2048)
