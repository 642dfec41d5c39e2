"""Proof that a bag is complete: counts, order, gaps, clocks; and a look at the channels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from hamr_description.errors import BagError
from hamr_description.names import Topic
from hamr_description.rates import TARGET_HZ, TARGET_NS

from .bag import Bag, open_bag
from .cdr import NS, stamp_ns, text
from .decode import decode_all
from .frames import SERVO_NAMES
from .run_info import RunInfo
from .suspicious import suspicious
from .topics import SERVO, TYPES

#: Topics with one message per 4 ms period; in /leg_targets a missed period is worth a warning only.
PERIODIC = (Topic.CLOCK, Topic.JOINT_STATES, Topic.ODOM)
_WATCHED = {Topic.SERVO_JOINTS: "positions", Topic.SERVO_ACTUATORS: "positions", Topic.SERVO_VOLTAGES: "effort"}


@dataclass(frozen=True, slots=True)
class Row:
    """One fact about a bag: what was looked at, whether it holds, and the figures."""

    name: str
    ok: bool
    detail: str


@dataclass(frozen=True, slots=True)
class Report:
    """Outcome of a check; `ok` if every row holds. Warnings are about the run, not about the bag."""

    bag: str
    rows: tuple[Row, ...]
    warnings: tuple[str, ...]

    @property
    def ok(self) -> bool:
        return all(row.ok for row in self.rows)


@dataclass(frozen=True, slots=True)
class _Series:
    """A servo topic in reading order: stamps (m,), log times (m,), points per message (m,), sample times (n,), values (n, 8)."""

    stamps: np.ndarray
    logged: np.ndarray
    points: np.ndarray
    times: np.ndarray
    values: np.ndarray


def check(bag: str | Path) -> Report:
    """Prove counts, order, gaps and clocks of a bag; BagError if it cannot be read at all."""
    with open_bag(bag) as opened:
        told = opened.counts.get(Topic.RUN_INFO)
        info = RunInfo.from_json(text(opened.raws(Topic.RUN_INFO)[1][-1])) if told else None
        rows = [_counted(opened)]
        warnings = [f"there is no {topic}" for topic in (Topic.RUN_INFO, *SERVO) if not opened.counts.get(topic)]
        series = {topic: _series(opened, topic) for topic in SERVO if opened.counts.get(topic)}
        for topic, found in series.items():
            rows += _servo_rows(topic, found, info)
            warnings += suspicious(topic, found.values)
            if not np.array_equal(found.logged, found.stamps):
                warnings.append(f"{topic}: log times are not the stamps, so another clock recorded it; the stamps count")
        rows += _agreement(series)
        clock = None
        for topic in (*PERIODIC, Topic.LEG_TARGETS):
            if opened.counts.get(topic):
                stamps = _stamps(opened, topic)
                clock = stamps if topic == Topic.CLOCK else clock
                regular = _steps(topic, stamps, TARGET_NS)
                if topic in PERIODIC:
                    rows += regular
                else:
                    warnings += [f"{row.name}: {row.detail}" for row in regular if not row.ok]
        if clock is not None:
            rows += [_on_clock(topic, found.stamps, clock) for topic, found in series.items()]
    if len(rows) == 1:
        raise BagError(f"{bag} holds none of {', '.join((*SERVO, *PERIODIC))}; record those topics.")
    return Report(str(bag), tuple(rows), tuple(warnings))


def _counted(opened: Bag) -> Row:
    stored = dict.fromkeys(opened.counts, 0)
    for message in opened.messages():
        stored[message.topic] += 1
    wrong = [f"{topic} {count} stored, {opened.counts[topic]} indexed" for topic, count in stored.items() if count != opened.counts[topic]]
    return Row("messages", not wrong, "; ".join(wrong) or f"{sum(stored.values())} stored, as the index says")


def _series(opened: Bag, topic: str) -> _Series:
    logged, raws = opened.raws(topic)
    stamps, points = np.zeros(len(raws), np.int64), np.zeros(len(raws), int)
    times, values = [None] * len(raws), [None] * len(raws)
    try:
        for indices, numbers in decode_all(raws, TYPES[topic], SERVO_NAMES[topic]):
            if _WATCHED[topic] not in numbers:
                raise BagError(f"there are messages without '{_WATCHED[topic]}' or without samples; record them.")
            stamps[indices] = numbers["stamp"]
            points[indices] = numbers["time_from_start"].shape[1]
            for row, i in enumerate(indices):
                times[i] = numbers["stamp"][row] + numbers["time_from_start"][row]
                values[i] = numbers[_WATCHED[topic]][row]
    except BagError as error:
        raise BagError(f"{opened.path}, {topic}: {error}") from None
    return _Series(stamps, np.array(logged), points, np.concatenate(times), np.concatenate(values))


def _stamps(opened: Bag, topic: str) -> np.ndarray:
    return np.array([stamp_ns(raw, TYPES[topic]) for raw in opened.raws(topic)[1]], np.int64)


def _steps(name: str, times: np.ndarray, step: float) -> Iterator[Row]:
    """Strictly increasing, and every step as long as it should be (to 1 %)."""
    steps = np.diff(times)
    gaps = steps > 1.01 * step
    missing = int(np.round(steps[gaps] / step - 1).sum())
    yield _row(f"{name} order", times, {"jumps back": steps < 0, "repeats": steps == 0}, "stamps increase")
    wrong = {f"{missing} missing": gaps, "steps too short": (steps > 0) & (steps < 0.99 * step)}
    yield _row(f"{name} gaps", times, wrong, f"every step is {step / 1e6:g} ms")


def _row(name: str, times: np.ndarray, wrong: dict[str, np.ndarray], right: str) -> Row:
    """A row that holds if none of the masks in `wrong` has a place; it says how often and where first."""
    found = [
        f"{what} in {np.sum(mask)} places, first at {times[np.argmax(mask)] / 1e9:.6f} s" for what, mask in wrong.items() if mask.any()
    ]
    return Row(name, not found, ", ".join(found) or right)


def _servo_rows(topic: str, found: _Series, info: RunInfo | None) -> Iterator[Row]:
    step = NS / info.sample_hz if info else float(np.median(np.diff(found.times))) if found.times.size > 1 else float(TARGET_NS)
    yield from _steps(topic, found.times, step)
    seconds = (found.times.max() - found.times.min() + step) / 1e9
    planned = info.excitation.get("seconds") if info else None
    if isinstance(planned, int | float) and np.isfinite(planned):
        seconds = round(planned * TARGET_HZ) / TARGET_HZ  # whole periods, as the excitation was made
    expected = round(seconds * 1e9 / step)
    rate = f"{seconds:.6g} s at {1e9 / step:.6g} Hz"
    yield Row(f"{topic} count", found.times.size == expected, f"{found.times.size} samples, {expected} expected ({rate})")
    if info:
        uneven = {"another number": found.points != info.samples_per_frame}
        yield _row(f"{topic} samples per frame", found.stamps, uneven, f"{info.samples_per_frame} in each")
    yield _row(f"{topic} numbers", found.times, {"not finite": ~np.isfinite(found.values).all(axis=1)}, "all finite")


def _agreement(series: dict[str, _Series]) -> Iterator[Row]:
    for first, topic in pairwise(series):
        same = np.array_equal(series[topic].times, series[first].times)
        yield Row(f"{topic} times", same, f"sample times {'equal' if same else 'differ from'} those of {first}")


def _on_clock(topic: str, stamps: np.ndarray, clock: np.ndarray) -> Row:
    return _row(f"{topic} on {Topic.CLOCK}", stamps, {"no tick": ~np.isin(stamps, clock)}, "every frame has its tick")
