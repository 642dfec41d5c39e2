"""Every `hamr` command that the documentation shows is one that the program understands."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from hamr_bringup.cli import AS_JSON, COMMANDS, _module, _parse

HERE = Path(__file__).parents[2]
PAGES = (HERE / "README.md", HERE / "bags" / "README.md", *sorted((HERE / "docs").glob("*.md")))


def commands(page: str) -> Iterator[list[str]]:
    """Words after `hamr` of the lines in code blocks, indented or fenced, without comments."""
    fenced = False
    for line in page.replace("\\\n", " ").splitlines():
        fenced ^= line.startswith("```")
        if (fenced or line.startswith("    ")) and line.strip().startswith("hamr "):
            yield shlex.split(line, comments=True)[1:]


SHOWN = [pytest.param(words, id=f"{page.name}: {' '.join(words)}") for page in PAGES for words in commands(page.read_text())]


def test_blocks_of_both_kinds_are_read_without_comments():
    page = "hamr no\n\n    hamr check  # why\n\n```\nhamr up \\\n  --seconds 5\n```\nhamr no\n"
    assert list(commands(page)) == [["check"], ["up", "--seconds", "5"]]


@pytest.mark.parametrize("words", SHOWN)
def test_it_parses(words):
    name, *rest = words
    assert name in COMMANDS
    _parse(_module(name), name, [word for word in rest if word != AS_JSON])
