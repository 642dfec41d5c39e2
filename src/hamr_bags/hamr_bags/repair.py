"""Rescue a bag that was never closed, or is cut off or damaged: every whole chunk goes into a new bag."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from itertools import chain
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC

from hamr_description.errors import BagError

from .cdr import store
from .writer import BagWriter


@dataclass(frozen=True, slots=True)
class Repaired:
    """What was rescued.

    Attributes:
        bag: the new bag.
        messages: number of messages in it.
        chunks: number of whole chunks found; 0 for a file written without chunks, whose whole messages are rescued.
        lost_bytes: bytes at the end of the file that belong to no whole record, plus damaged chunks.
        left_out: topics whose message type is no standard one.
    """

    bag: Path
    messages: int
    chunks: int
    lost_bytes: int
    left_out: tuple[str, ...]


def repair(bag: str | Path, out: str | Path | None = None) -> Repaired:
    """Copy what is whole in a bag into a new one with index and metadata; the old one stays as it is.

    Args:
        bag: bag folder or .mcap file.
        out: folder to make; default the bag's name with `_repaired`.

    BagError if there is no MCAP file, nothing whole in it, or `out` exists.
    """
    path = Path(bag)
    out = Path(out) if out else beside(path, "_repaired")
    salvage = Salvage()
    messages = (message for file in _files(path) for message in salvage.messages(file))
    first = next(messages, None)
    if first is None:
        raise BagError(f"{path} holds no whole chunk, so nothing can be rescued; record the bag again.")
    count = 0
    with BagWriter(out) as writer:
        for topic, msgtype, message in chain([first], messages):
            writer.write(topic, message.data, message.log_time, msgtype)
            count += 1
    return Repaired(out, count, salvage.chunks, salvage.lost_bytes, tuple(sorted(salvage.left_out)))


def beside(bag: str | Path, suffix: str) -> Path:
    """A name for a bag made from another: in the same folder, with a suffix."""
    path = Path(bag).resolve()
    return path.with_name((path.name if path.is_dir() else path.stem) + suffix)


class Salvage:
    """Reads the whole records of MCAP files and keeps account of what it had to leave."""

    def __init__(self) -> None:
        self.chunks = self.lost_bytes = 0
        self.left_out: set[str] = set()

    def messages(self, file: Path) -> Iterator[tuple[str, str, Message]]:
        """(topic, message type, message) of each message in a whole record, in file order."""
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        for record in self._records(file):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                msgtype = schemas[channel.schema_id].name if channel.schema_id in schemas else ""
                if msgtype in store().types and channel.message_encoding == "cdr":
                    yield channel.topic, msgtype, record
                else:
                    self.left_out.add(channel.topic)

    def _records(self, file: Path) -> Iterator[McapRecord]:
        size, chunked = file.stat().st_size, False
        with file.open("rb") as stream:
            if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise BagError(f"{file} is no MCAP file; give a bag folder or a .mcap file.")
            while True:
                start = stream.tell()
                head = stream.read(9)
                opcode, length = (head[0], int.from_bytes(head[1:], "little")) if len(head) == 9 else (0, 0)
                if opcode == Opcode.DATA_END:
                    return  # behind it there is only the index
                if opcode == 0 or start + 9 + length > size:
                    self.lost_bytes += size - start
                    return
                chunked |= opcode == Opcode.CHUNK
                # Chunks have checksums; beside them a stray message or channel is a damaged index.
                if opcode == Opcode.CHUNK or (opcode in _READ and not chunked):
                    yield from self._parse(opcode, stream.read(length))
                else:
                    stream.seek(length, os.SEEK_CUR)

    def _parse(self, opcode: int, content: bytes) -> list[McapRecord]:
        try:
            records = _READ[opcode](ReadDataStream(BytesIO(content)), len(content))
        except Exception:  # whatever a parser or decompressor raises on damaged bytes
            self.lost_bytes += len(content)
            return []
        self.chunks += opcode == Opcode.CHUNK
        return records


_READ = {
    Opcode.SCHEMA: lambda stream, _: [Schema.read(stream)],
    Opcode.CHANNEL: lambda stream, _: [Channel.read(stream)],
    Opcode.MESSAGE: lambda stream, length: [Message.read(stream, length)],
    Opcode.CHUNK: lambda stream, _: breakup_chunk(Chunk.read(stream), validate_crc=True),
}


def _files(path: Path) -> list[Path]:
    if not path.exists():
        raise BagError(f"There is no bag at {path}; give a bag folder or a .mcap file.")
    files = sorted(path.glob("*.mcap"), key=lambda file: (len(file.name), file.name)) if path.is_dir() else [path]
    if not files:
        raise BagError(f"{path} holds no .mcap file; only MCAP bags can be repaired.")
    return files
