"""What a bag holds, at a glance."""

from __future__ import annotations

from pathlib import Path

from hamr_description.errors import BagError
from hamr_description.names import Topic

from .bag import open_bag
from .cdr import text
from .run_info import RunInfo


def info(bag: str | Path) -> dict:
    """JSON-able summary: path, bytes, start and seconds (s), topics [{topic, type, messages, hz}], run_info or None.

    Rates are messages per second of sim time between a topic's first and last message.
    """
    with open_bag(bag) as opened:
        first: dict[str, int] = {}
        last: dict[str, int] = {}
        counts = dict.fromkeys(opened.types, 0)
        run_info = None
        for message in opened.messages():
            first.setdefault(message.topic, message.log_ns)
            last[message.topic] = message.log_ns
            counts[message.topic] += 1
            if message.topic == Topic.RUN_INFO:
                run_info = RunInfo.from_json(text(message.raw))
        if not first:
            raise BagError(f"{opened.path} is empty; record it again.")
        path = opened.path
        files = [file for file in path.iterdir() if file.is_file()] if path.is_dir() else [path]
    start, end = min(first.values()), max(last.values())
    return {
        "bag": str(path),
        "bytes": sum(file.stat().st_size for file in files),
        "start": start / 1e9,
        "seconds": (end - start) / 1e9,
        "topics": [
            {"topic": topic, "type": opened.types[topic], "messages": count, "hz": _hz(count, last.get(topic, 0) - first.get(topic, 0))}
            for topic, count in sorted(counts.items())
        ],
        "run_info": run_info and run_info.as_dict(),
    }


def _hz(count: int, span_ns: int) -> float | None:
    return (count - 1) * 1e9 / span_ns if span_ns else None
