"""What `hamr bag COMMAND` does, as functions that return JSON-able objects; errors are HamrError."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from . import check as _check
from . import flatten as _flatten
from . import info as _info
from . import repair as _repair


def check(bag: Path) -> dict:
    """{ok, bag, rows: [{name, ok, detail}], warnings: [...]}; the command fails if not ok."""
    report = _check.check(bag)
    return {"ok": report.ok, **asdict(report)}


def repair(bag: Path, out: Path | None = None) -> dict:
    """{bag, messages, chunks, lost_bytes, left_out}: the new bag and what is in it."""
    found = asdict(_repair.repair(bag, out))
    return found | {"bag": str(found["bag"])}


def info(bag: Path) -> dict:
    """{bag, bytes, start, seconds, topics: [{topic, type, messages, hz}], run_info}."""
    return _info.info(bag)


def flatten(bag: Path, out: Path | None = None) -> dict:
    """{bag, samples}: the flattened bag, by default beside the other with `_flat` added to its name."""
    out = out or _repair.beside(bag, "_flat")
    return {"bag": str(out), "samples": _flatten.flatten(bag, out)}
