"""Frames to samples: stitched by their stamps, topics brought to common times. Times are int64 ns."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from hamr_description.errors import BagError

from .layout import Numbers


def stitch(groups: Iterable[Numbers], fields: Collection[str]) -> tuple[np.ndarray, Numbers]:
    """Messages grouped by layout -> times (n,), strictly increasing, and each field (n, ...); of repeated times the first counts.

    BagError if a message lacks a field or holds a number that is not finite.
    """
    times, values = [], {field: [] for field in fields}
    for numbers in groups:
        time = numbers["stamp"]
        if "time_from_start" in numbers:
            time = (time[:, None] + numbers["time_from_start"]).ravel()
        if not time.size:
            continue
        times.append(time)
        for field in fields:
            if field not in numbers:
                raise BagError(f"there are messages without '{field}'; record it, or do not declare that channel as measured.")
            array = numbers[field]
            array = array.reshape(time.size, array.shape[-1])
            if not np.isfinite(array).all():
                bad = time[np.flatnonzero(~np.isfinite(array).all(axis=1))[0]]
                raise BagError(f"'{field}' is not a finite number at {bad / 1e9:.6f} s; cut that stretch out or record again.")
            values[field].append(array)
    if not times:
        raise BagError("the messages hold no samples; record the bag again.")
    unique, first = np.unique(np.concatenate(times), return_index=True)
    return unique, {field: np.concatenate(arrays)[first] for field, arrays in values.items()}


def common(times: dict[str, np.ndarray], held: dict[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times that all of `times` share and at which all of `held` are known; and each key's rows there.

    A held topic keeps a value until its next one; before a gap and at the end, until the next is due (one median step).
    """
    shared = None
    for time in times.values():
        shared = time if shared is None else np.intersect1d(shared, time, assume_unique=True)
    for time in held.values():
        latest = np.searchsorted(time, shared, side="right") - 1
        steps = np.diff(time)
        step = np.median(steps) if steps.size else np.inf
        until = time + np.append(np.where(steps < 1.5 * step, steps, step), step)
        shared = shared[(latest >= 0) & (shared < until[latest])]
    if not shared.size:
        spans = ", ".join(f"{key} {time[0] / 1e9:.6f} to {time[-1] / 1e9:.6f} s" for key, time in {**times, **held}.items())
        raise BagError(f"no sample time is common to the topics ({spans}); record them in one run with one clock.")
    return shared, {key: np.searchsorted(time, shared, side="right") - 1 for key, time in {**times, **held}.items()}
