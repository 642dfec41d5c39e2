"""Opening a bag, whichever ROS 2 tool recorded it: a folder with metadata.yaml, or a bare .mcap or .db3 file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rosbags.rosbag2 import Reader

from hamr_description.errors import BagError

from .topics import TYPES

METADATA = "metadata.yaml"


@dataclass(frozen=True, slots=True)
class Message:
    """One stored message: its topic, type, log time in ns and CDR bytes."""

    topic: str
    msgtype: str
    log_ns: int
    raw: bytes


@dataclass(frozen=True, slots=True)
class Bag:
    """An opened bag.

    Attributes:
        path: as given.
        types: topic -> message type.
        counts: topic -> number of messages, as the bag's index has it.
    """

    path: Path
    types: dict[str, str]
    counts: dict[str, int]
    _reader: Reader

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """Messages of some topics (default all) in log time order; BagError where the file turns out to be damaged."""
        wanted = [c for c in self._reader.connections if topics is None or c.topic in topics]
        if not wanted:
            return
        with _readable(self.path):
            for connection, log_ns, raw in self._reader.messages(wanted):
                yield Message(connection.topic, connection.msgtype, log_ns, raw)

    def raws(self, topic: str) -> tuple[list[int], list[bytes]]:
        """Log times (ns) and bytes of every message of a topic of ours; BagError as of `require`."""
        self.require(topic)
        messages = list(self.messages([topic]))
        return [message.log_ns for message in messages], [message.raw for message in messages]

    def require(self, topic: str) -> None:
        """BagError if a topic of ours is missing, empty or of another type."""
        if not self.counts.get(topic):
            known = ", ".join(sorted(topic for topic, count in self.counts.items() if count)) or "nothing"
            raise BagError(f"{self.path} holds no {topic} (it holds {known}); record that topic too.")
        if self.types[topic] != TYPES[topic]:
            raise BagError(f"{self.path} holds {topic} as {self.types[topic]}; it must be {TYPES[topic]}.")


@contextmanager
def open_bag(path: str | Path) -> Iterator[Bag]:
    """Open a bag for reading; BagError says what is wrong with it and what to do."""
    path = Path(path)
    if not path.exists():
        raise BagError(f"There is no bag at {path}; give a bag folder or a .mcap file.")
    if path.is_dir() and not (path / METADATA).exists():
        if any(path.glob("*.mcap")):
            raise BagError(f"{path} was not closed: it has no {METADATA}; run `hamr bag repair {path}`.")
        raise BagError(f"{path} is not a bag: it has no {METADATA} and no .mcap file; give a bag folder or a .mcap file.")
    if path.is_file() and path.suffix not in (".mcap", ".db3"):
        raise BagError(f"{path} is not a bag: its name ends neither in .mcap nor in .db3; give a bag folder or a .mcap file.")
    with _readable(path):
        reader = Reader(path)
        reader.open()
    try:
        counts: Counter[str] = Counter()
        for connection in reader.connections:
            counts[connection.topic] += connection.msgcount
        yield Bag(path, {c.topic: c.msgtype for c in reader.connections}, dict(counts), reader)
    finally:
        reader.close()


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Turn whatever a parser raises on hostile bytes into one sentence."""
    try:
        yield
    except BagError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise BagError(f"{path} is damaged or cut off ({reason.rstrip('.')}); run `hamr bag repair {path}`.") from error
