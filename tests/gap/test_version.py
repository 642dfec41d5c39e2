"""What was finished by other code, other numbers or another model is not taken up again."""

from __future__ import annotations

import pytest

from hamr_gap.answers import version


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "robot_of_this_test"
    (folder / "models").mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    (folder / "models" / "residual.json").write_text("{}")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(version, "PACKAGES", (folder.name,))
    return folder


@pytest.mark.parametrize("file", ["__init__.py", "models/residual.json", "numbers.yaml"])
def test_any_source_number_or_model_makes_another_version(package, file):
    before = version.code.__wrapped__()
    assert version.code.__wrapped__() == before
    (package / file).write_text("# 1")
    assert version.code.__wrapped__() != before


def test_what_decides_nothing_makes_no_other_version(package):
    before = version.code.__wrapped__()
    (package / "notes.md").write_text("read me")
    assert version.code.__wrapped__() == before
