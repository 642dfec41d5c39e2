"""The one table of how topics are sent and received."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from hamr_bags.topics import LATCHED, TYPES
from hamr_description.names import Topic

#: Messages a publisher keeps for listeners that lag: 4 s of sim time at 250 Hz.
SENT_DEPTH = 1000
#: Messages a control node keeps. Of the robot's state only the newest counts; a target is never overwritten unread, so a bad one is named.
_HEARD_DEPTH = {Topic.JOINT_STATES: 1, Topic.ODOM: 1}


@cache
def message_class(topic: str) -> type:
    """Message class of a topic."""
    package, _, name = TYPES[topic].split("/")
    return getattr(import_module(f"{package}.msg"), name)


def _profile(topic: str, history: HistoryPolicy, depth: int) -> QoSProfile:
    durability = DurabilityPolicy.TRANSIENT_LOCAL if topic in LATCHED else DurabilityPolicy.VOLATILE
    return QoSProfile(history=history, depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=durability)


def sent(topic: str) -> QoSProfile:
    """For the publisher of a topic."""
    return _profile(topic, HistoryPolicy.KEEP_LAST, 1 if topic in LATCHED else SENT_DEPTH)


def heard(topic: str) -> QoSProfile:
    """For a node that acts on a topic."""
    return _profile(topic, HistoryPolicy.KEEP_LAST, _HEARD_DEPTH.get(topic, 10))


def recorded(topic: str) -> QoSProfile:
    """For the recorder, which must miss nothing."""
    return _profile(topic, HistoryPolicy.KEEP_ALL, 0)
