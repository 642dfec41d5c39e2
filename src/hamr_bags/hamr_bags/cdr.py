"""CDR bytes and message objects: rosbags' Jazzy types, without ROS."""

from __future__ import annotations

import struct
from functools import cache

from rosbags.interfaces import Typestore
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from hamr_description.errors import BagError

from .topics import CLOCK, JOINT_STATE, ODOMETRY, STRING, TRAJECTORY

NS = 1_000_000_000
_STAMPED = frozenset({CLOCK, JOINT_STATE, ODOMETRY, TRAJECTORY, "diagnostic_msgs/msg/DiagnosticArray"})


@cache
def store() -> Typestore:
    """rosbags' type store of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def serialize(message: object, msgtype: str) -> bytes:
    """CDR bytes (little endian) of a message made of `store().types`."""
    return bytes(store().serialize_cdr(message, msgtype, little_endian=True))


def deserialize(raw: bytes, msgtype: str) -> object:
    """Message object of CDR bytes, either endianness; BagError if they are not of this type.

    Bytes after the message are ignored: rclpy.serialization.serialize_message leaves uninitialised ones there,
    which `store().deserialize_cdr` refuses.
    """
    try:
        if raw[:2] not in (b"\x00\x00", b"\x00\x01"):
            raise ValueError("it does not start as CDR does")
        definition = store().get_msgdef(msgtype)
        read = definition.deserialize_cdr_le if raw[1] else definition.deserialize_cdr_be
        message, _ = read(memoryview(raw)[4:], 0, definition.cls, store())
    except (SerdeError, struct.error, ValueError, IndexError) as error:  # UnicodeDecodeError is a ValueError
        raise BagError(f"A message of type {msgtype} cannot be decoded ({error}); record the bag again.") from None
    return message


def text(raw: bytes) -> str:
    """The text of a std_msgs/String."""
    return deserialize(raw, STRING).data


def string(text: str) -> bytes:
    """CDR bytes of a std_msgs/String."""
    return serialize(store().types[STRING](text), STRING)


def stamp_ns(raw: bytes, msgtype: str) -> int | None:
    """Time stamp of a message in ns: its header's, or a Clock's own; None for types without one."""
    if msgtype not in _STAMPED:
        return None
    if len(raw) < 12:
        raise BagError(f"A message of type {msgtype} is too short to hold its time stamp; record the bag again.")
    seconds, nanoseconds = struct.unpack_from("<iI" if raw[1] else ">iI", raw, 4)
    return seconds * NS + nanoseconds
