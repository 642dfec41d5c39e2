"""Recording: what the recorder node does with the bytes it is given, without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hamr_description.errors import BagError

from .cdr import stamp_ns
from .topics import TYPES
from .writer import BagWriter


class Recorder:
    """Stores serialized messages in a bag, in the order of the sim clock; a context manager.

    Messages without a stamp of their own (/run_info, /cmd_vel, ...) get the newest sim time seen. Those that come before
    any are kept until the clock is known, so that a recorder that joins late does not begin its bag at time 0.
    """

    def __init__(self, out: str | Path, types: Mapping[str, str] = TYPES) -> None:
        """Args: out, folder to make; types, topic -> message type."""
        self._types = dict(types)
        self._writer = BagWriter(out)
        self._last: dict[str, int] = {}
        self._now: int | None = None
        self._early: list[tuple[str, bytes]] = []

    @property
    def path(self) -> Path:
        return self._writer.path

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, topic: str, raw: bytes, stamp: int | None = None) -> None:
        """Store one message.

        Args:
            topic: one of the topics given.
            raw: CDR bytes, as a raw subscription hands them over.
            stamp: sim time in ns; default the message's own.

        BagError if the topic is unknown or its stamp jumps back; the message is then left out and recording may go on.
        """
        if topic not in self._types:
            raise BagError(f"{topic} is not recorded; the topics are {', '.join(self._types)}.")
        stamp = stamp_ns(raw, self._types[topic]) if stamp is None else stamp
        if stamp is None and self._now is None:
            self._early.append((topic, raw))
            return
        if stamp is None:
            stamp = self._now
        if stamp < self._last.get(topic, stamp):
            back = (self._last[topic] - stamp) / 1e9
            raise BagError(f"{topic} jumped back by {back:.6g} s to {stamp / 1e9:.6f} s; start a new bag after resetting the clock.")
        self._last[topic] = stamp
        self._now = stamp if self._now is None else max(self._now, stamp)
        self._flush(stamp)
        self._writer.write(topic, raw, stamp, self._types[topic])

    def close(self) -> None:
        """Write what is left and close the bag; a second call does nothing."""
        self._flush(0)
        self._writer.close()

    def _flush(self, stamp: int) -> None:
        early, self._early = self._early, []
        for topic, raw in early:
            self._writer.write(topic, raw, stamp, self._types[topic])
