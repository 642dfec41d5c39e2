"""From CDR bytes to arrays in canonical joint order, whoever wrote them and in whatever order its joints stand.

Messages that differ only in their numbers are read in one numpy view; the first of each kind is decoded by rosbags to
learn its layout. Bytes that differ in padding or endianness go through rosbags once to become canonical.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hamr_description.errors import BagError

from .cdr import NS, deserialize, serialize
from .frames import layout_of
from .layout import Layout, Numbers


def order(names: Sequence[str], expected: Sequence[str]) -> list[int]:
    """Positions at which the expected joints stand in `names`; BagError names what is missing, repeated or unknown."""
    for what, wrong in (
        ("repeats", sorted({name for name in names if names.count(name) > 1})),
        ("lacks", [name for name in expected if name not in names]),
        ("has the unknown", [name for name in names if name not in expected]),
    ):
        if wrong:
            raise BagError(f"A message {what} joint {', '.join(wrong)}; it needs exactly {', '.join(expected)}.")
    return [names.index(name) for name in expected]


def nanoseconds(pairs: np.ndarray) -> np.ndarray:
    """(..., 2) int32 seconds and nanoseconds -> (...,) int64 ns."""
    return pairs[..., 0].astype(np.int64) * NS + pairs[..., 1].view(np.uint32)


class Decoder:
    """Reads the messages of one topic one by one, as a node does; remembers the last layout."""

    def __init__(self, msgtype: str, joints: Sequence[str] = ()) -> None:
        """Args: joints expected, in the order wanted; none for types without joints."""
        self._msgtype, self._joints = msgtype, tuple(joints)
        self._layout: Layout | None = None
        self._order: list[int] | None = None

    def __call__(self, raw: bytes) -> Numbers:
        """Numbers by field, joints along the last axis; `stamp` and `time_from_start` are int64 ns. BagError if it does not fit."""
        if self._layout is None or not self._layout.fits([raw])[0]:
            message = deserialize(raw, self._msgtype)
            layout = layout_of(message)
            self._order = _columns(layout, self._joints)
            self._layout = layout  # not before its joints are known to be right, or the next such message would pass
            raw = serialize(message, self._msgtype)
        return _arrange(self._layout.views(raw), self._order)


def decode_all(raws: list[bytes], msgtype: str, joints: Sequence[str] = ()) -> Iterator[tuple[np.ndarray, Numbers]]:
    """Messages grouped by layout: their indices (m,), and their numbers as of `Decoder` with a leading axis of m."""
    rest, canonical = np.arange(len(raws)), False
    while rest.size:
        message = deserialize(raws[rest[0]], msgtype)
        layout = layout_of(message)
        fit = layout.fits([raws[i] for i in rest])
        if not fit[0] and not canonical:  # foreign padding or endianness: once through rosbags
            raws, canonical = [serialize(deserialize(raw, msgtype), msgtype) for raw in raws], True
            fit = layout.fits([raws[i] for i in rest])
        group, rest = rest[fit], rest[~fit]
        numbers = layout.views(layout.join([raws[i] for i in group]), group.size)
        yield group, _arrange(numbers, _columns(layout, joints))


def _columns(layout: Layout, joints: Sequence[str]) -> list[int] | None:
    """Columns to pick, or None where they stand in order already, so that nothing is copied."""
    return None if layout.names == tuple(joints) or not joints else order(layout.names, joints)


def _arrange(numbers: Numbers, columns: list[int] | None) -> Numbers:
    times = {name: nanoseconds(numbers[name]) for name in ("stamp", "time_from_start") if name in numbers}
    values = {name: array for name, array in numbers.items() if name not in times}
    return times | (values if columns is None else {name: array[..., columns] for name, array in values.items()})
