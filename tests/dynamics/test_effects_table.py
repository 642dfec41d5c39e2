"""docs/effects.md holds the library as it is, and an example that can be read."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hamr_dynamics.effects.effects_file import read
from hamr_dynamics.effects.law import PARTS, powers
from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.table import table

PAGE = Path(__file__).parents[2] / "docs" / "effects.md"


def test_the_table_is_current():
    assert table() in PAGE.read_text(), "write it anew: python -m hamr_dynamics.effects.table"


def test_the_example_is_an_effects_file(tmp_path):
    (example,) = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    path = tmp_path / "example.yaml"
    path.write_text(example)
    assert {entry.effect for entry in read(path).effects} <= set(library())


@pytest.mark.parametrize("effect", library().values(), ids=lambda effect: effect.name)
def test_every_effect_is_complete(effect):
    assert effect.part in PARTS
    assert effect.summary.endswith(".") and effect.experiment and effect.source
    assert len({form.name for form in effect.forms}) == len(effect.forms)
    for form in effect.forms:
        assert form.sizes  # something that switches it off
        for parameter in form.parameters:
            assert parameter.low <= parameter.typical <= parameter.high and parameter.doc
            assert all(letter in "FQTSUNLM" for letter, _ in powers(parameter.dimension))
            assert parameter.shape or parameter.low <= 0.0 <= parameter.high  # off is allowed
