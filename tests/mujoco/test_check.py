"""`hamr check`: the table that people see, and that it can tell right from wrong."""

from __future__ import annotations

import pytest

from hamr_description.simple_constants import simple_constants
from hamr_sim_full import check
from hamr_sim_residual.derive import derive


def test_every_row_holds_but_those_with_a_known_reason():
    result = check.check()
    off = [row["name"] for row in result["rows"] if not row["ok"]]
    known = ["lift quality factor, robot", "swing quality factor, robot", "heave resonance, robot", "static sag, settled"]
    assert result["ok"] and off == known
    assert all(row["source"] and row["unit"] for row in result["rows"])


def test_a_wrong_number_shows(monkeypatch):
    right = check.value
    monkeypatch.setattr(check, "value", lambda path: right(path) * (1.05 if path == "robot.gravity" else 1.0))
    row = next(row for row in check._statics() if row.name == "static sag, linear")
    assert not row.ok


def test_shipped_constants_of_simple_are_the_derived_ones():
    for group, numbers in derive().items():
        for name, number in numbers.items():
            assert simple_constants()[group][name] == pytest.approx(number, rel=1e-9, abs=1e-12), f"{group}.{name}"
