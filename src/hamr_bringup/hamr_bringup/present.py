"""A result as text for people, or as one JSON object."""

from __future__ import annotations

import json
import math
from io import StringIO
from pathlib import Path
from typing import Any


def as_json_text(result: dict) -> str:
    """One line of strict JSON: NaN and infinity, which JSON does not know, become null."""
    return json.dumps(_plain(result), allow_nan=False) + "\n"


def as_text(result: dict) -> str:
    """`rows` as a table with the keys of the first row as heads, everything else as `key: value` lines below it."""
    from rich.console import Console
    from rich.table import Table

    text = StringIO()
    console = Console(file=text, width=200, no_color=True)
    rows = result.get("rows", [])
    if rows:
        table = Table(*rows[0], box=None, pad_edge=False)
        for row in rows:
            table.add_row(*(_cell(row.get(key)) for key in rows[0]))
        console.print(table)
    lines = [f"{key}: {_cell(value)}" for key, value in result.items() if key != "rows"]
    return "".join(f"{line.rstrip()}\n" for line in [*text.getvalue().splitlines(), *lines])


def _cell(value: Any) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "NO"
        case float():
            return f"{value:.4g}"
        case dict():
            return ", ".join(f"{key} {_cell(item)}" for key, item in value.items())
        case list() | tuple():
            return ", ".join(_cell(item) for item in value)
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
