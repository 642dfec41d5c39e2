"""A bag cut at any byte, or damaged at any, is repaired up to its whole chunks or refused in one sentence."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from bag_samples import cdr, foreign, run
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import Reader

from hamr_bags.check import check
from hamr_bags.reader import load
from hamr_bags.recording import digest
from hamr_bags.repair import repair
from hamr_bags.writer import BagWriter
from hamr_description.errors import BagError

Stored = list[tuple[str, int, bytes]]


def stored(bag: Path) -> Stored:
    with Reader(bag) as reader:
        return [(c.topic, stamp, bytes(raw)) for c, stamp, raw in reader.messages()]


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A bag of many small chunks."""
    folder = tmp_path_factory.mktemp("repair")
    source = run(frames=20)
    original = foreign(folder / "source", source, info=source.info().to_json())
    with Reader(original) as reader, BagWriter(folder / "run", chunk_bytes=6000) as writer:
        for connection, stamp, raw in reader.messages():
            writer.write(connection.topic, bytes(raw), stamp)
    return folder / "run"


@pytest.fixture(scope="module")
def chunks(whole) -> list[tuple[int, int]]:
    """(end of the chunk in the file, messages up to there), by the index of the whole file."""
    ends, total = [], 0
    with (whole / "run.mcap").open("rb") as stream:
        for index in make_reader(stream).get_summary().chunk_indexes:
            stream.seek(index.chunk_start_offset + index.chunk_length)
            ends.append((stream.tell(), index))
        counts = [sum(size // 16 for size in _index_sizes(index)) for _, index in ends]
    result = []
    for (end, _), count in zip(ends, counts, strict=True):
        total += count
        result.append((end, total))
    assert total == len(stored(whole))
    assert len(result) > 10
    return result


def _index_sizes(index) -> list[int]:
    """Bytes of entries in each message index record behind a chunk: between offsets, less 9 + 2 + 4 of head."""
    offsets = sorted(index.message_index_offsets.values())
    ends = [*offsets[1:], index.chunk_start_offset + index.chunk_length + index.message_index_length]
    return [end - offset - 15 for offset, end in zip(offsets, ends, strict=True)]


@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_cut_at_any_byte(data, whole, chunks, tmp_path_factory):
    content = (whole / "run.mcap").read_bytes()
    cut = data.draw(st.integers(0, len(content)) | st.sampled_from([end + d for end, _ in chunks for d in (-1, 0, 1)]))
    bag = tmp_path_factory.mktemp("cut") / "run"
    bag.mkdir()
    (bag / "run.mcap").write_bytes(content[:cut])
    expected = max([count for end, count in chunks if end <= cut], default=0)
    if not expected:
        with pytest.raises(BagError, match=r"^[^\n]+[.]$"):
            repair(bag)
        return
    repaired = repair(bag)
    assert repaired.messages == expected
    assert repaired.bag == bag.with_name("run_repaired")
    assert stored(repaired.bag) == stored(whole)[:expected]
    assert (bag / "run.mcap").read_bytes() == content[:cut]  # the original stays
    assert "messages" not in {row.name for row in check(repaired.bag).rows if not row.ok}


@given(place=st.integers(0, 10**6), value=st.integers(1, 255), spread=st.integers(1, 40))
@settings(max_examples=80, deadline=None)
def test_damaged_at_any_byte(place, value, spread, whole, chunks, tmp_path_factory):
    content = bytearray((whole / "run.mcap").read_bytes())
    place %= len(content)
    content[place : place + spread] = bytes(byte ^ value for byte in content[place : place + spread])
    before = max([count for end, count in chunks if end <= place], default=0)
    file = tmp_path_factory.mktemp("damaged") / "run.mcap"
    file.write_bytes(content)
    try:
        repaired = repair(file)
    except BagError as error:
        assert "\n" not in str(error)
        assert before == 0
        return
    truth, found = stored(whole), stored(repaired.bag)
    assert found[:before] == truth[:before]
    assert all(entry in truth for entry in found)


def test_a_damaged_index_is_not_taken_for_a_message(whole, chunks, tmp_path):
    """Behind a chunk stands the index of a channel; with opcode 5 instead of 7 it would parse as a message on it."""
    content = bytearray((whole / "run.mcap").read_bytes())
    place = chunks[3][0]
    assert content[place] == 7
    content[place] = 5
    (tmp_path / "run.mcap").write_bytes(content)
    assert stored(repair(tmp_path / "run.mcap").bag) == stored(whole)


def test_a_file_that_ends_in_zeros_as_after_a_power_cut(whole, chunks, tmp_path):
    end, count = chunks[4]
    (tmp_path / "run.mcap").write_bytes((whole / "run.mcap").read_bytes()[:end] + bytes(5000))
    repaired = repair(tmp_path / "run.mcap")
    assert (repaired.messages, repaired.lost_bytes) == (count, 5000)


def test_a_whole_bag_stays_the_same(whole, tmp_path):
    repaired = repair(whole, tmp_path / "again")
    assert repaired.lost_bytes == 0
    assert digest(load(repaired.bag)) == digest(load(whole))


def test_only_the_metadata_missing(whole, tmp_path):
    bag = shutil.copytree(whole, tmp_path / "run")
    (bag / "metadata.yaml").unlink()
    with pytest.raises(BagError, match=f"run `hamr bag repair {bag}`"):
        load(bag)
    assert stored(repair(bag).bag) == stored(whole)


def test_several_files_become_one_bag_in_their_order(tmp_path):
    raws = [cdr("std_msgs/msg/Int32", i) for i in range(12)]
    bag = tmp_path / "split"
    bag.mkdir()
    for i, raw in enumerate(raws):  # split_0 .. split_11: by number, not by letter
        _mcap(bag / f"split_{i}.mcap", [("/number", raw, i)])
    assert stored(repair(bag).bag) == [("/number", i, raw) for i, raw in enumerate(raws)]


@pytest.mark.parametrize("compression", CompressionType)
@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_other_writers(tmp_path, compression, chunked):
    raws = [("/number", cdr("std_msgs/msg/Int32", i), i) for i in range(50)]
    file = _mcap(tmp_path / "other.mcap", raws, compression=compression, use_chunking=chunked, chunk_size=400)
    file.write_bytes(file.read_bytes()[:-300])
    repaired = repair(file)
    assert stored(repaired.bag) == [(topic, stamp, raw) for topic, raw, stamp in raws[: repaired.messages]]
    assert repaired.messages > 10


def test_topics_of_unknown_types_are_left_out_and_named(tmp_path):
    file = _mcap(tmp_path / "x.mcap", [("/a", b"1", 0)], msgtype="my_msgs/msg/Odd")
    with pytest.raises(BagError, match="holds no whole chunk"):
        repair(file)
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        for topic, msgtype in (("/odd", "my_msgs/msg/Odd"), ("/number", "std_msgs/msg/Int32")):
            channel = writer.register_channel(topic, "cdr", writer.register_schema(msgtype, "ros2msg", b""))
            writer.add_message(channel, 0, cdr("std_msgs/msg/Int32", 1), 0)
        writer.finish()
    assert repair(file).left_out == ("/odd",)


def _mcap(file: Path, messages, msgtype: str = "std_msgs/msg/Int32", **options) -> Path:
    with file.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start("ros2")
        channel = writer.register_channel(messages[0][0], "cdr", writer.register_schema(msgtype, "ros2msg", b"int32 data"))
        for _, raw, stamp in messages:
            writer.add_message(channel, stamp, raw, stamp)
        writer.finish()
    return file


@pytest.mark.parametrize("content", [b"", b"hello", bytes(100)])
def test_what_is_no_mcap_file_is_refused(tmp_path, content):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(BagError, match="is no MCAP file"):
        repair(tmp_path / "x.mcap")


def test_nothing_there(tmp_path):
    with pytest.raises(BagError, match="There is no bag at"):
        repair(tmp_path / "none")
    with pytest.raises(BagError, match="holds no .mcap file"):
        repair(tmp_path)


def test_the_place_for_the_new_bag_must_be_free(whole):
    with pytest.raises(BagError, match="exists already"):
        repair(whole, whole)
