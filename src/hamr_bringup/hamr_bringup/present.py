"""A result as text for people, or as one JSON object."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path
from typing import Any


def as_json_text(result: dict) -> str:
    """One line of strict JSON: NaN and infinity, which JSON does not know, become null."""
    return json.dumps(_plain(result), allow_nan=False) + "\n"


def as_text(result: dict) -> str:
    """Tables for lists of objects, `key: value` lines for the rest, in order; the verdict `ok` comes last."""
    ordered = {key: value for key, value in result.items() if key != "ok"} | {key: value for key, value in result.items() if key == "ok"}
    return "".join(f"{line.rstrip()}\n" for line in _lines(ordered))


def _lines(result: dict) -> Iterator[str]:
    for key, value in result.items():
        if value and isinstance(value, list | tuple) and all(isinstance(row, dict) for row in value):
            if key != "rows":
                yield f"{key}:"
            yield from _table(value)
        elif value and isinstance(value, dict):
            yield f"{key}:"
            yield from (f"  {line}" for line in _lines(value))
        else:
            yield f"{key}: {_cell(value)}"


def _table(rows: Sequence[dict]) -> list[str]:
    """The keys of the first row are the heads."""
    from rich.console import Console
    from rich.table import Table

    table = Table(*rows[0], box=None, pad_edge=False)
    for row in rows:
        table.add_row(*(_cell(row.get(key)) for key in rows[0]))
    text = StringIO()
    Console(file=text, width=200, no_color=True).print(table)
    return text.getvalue().splitlines()


def _cell(value: Any) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.4g}"
        case dict():
            return ", ".join(f"{key} {_cell(item)}" for key, item in value.items()) or "none"
        case list() | tuple():
            return ", ".join(_cell(item) for item in value) or "none"
        case _:
            return str(value)


def _plain(value: Any) -> Any:
    match value:
        case dict():
            return {str(key): _plain(item) for key, item in value.items()}
        case list() | tuple():
            return [_plain(item) for item in value]
        case Path():
            return str(value)
        case float():
            return value if math.isfinite(value) else None
        case _:
            return _plain(value.tolist()) if hasattr(value, "tolist") else value  # numpy
