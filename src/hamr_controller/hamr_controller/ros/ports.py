"""A node's publishers and its status in /diagnostics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from time import monotonic

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.duration import Duration
from rclpy.node import Node

from hamr_description.names import Topic

from ..health import Health, Level
from . import qos
from .run import RECORDER

_DIAGNOSTICS_S = 1.0
_ACKED_EVERY = 256  # periods; a quarter of what a publisher keeps
_ACKED_WAIT_S = 2.0
_ACKED_STEP = Duration(seconds=0.002)


class Publishers:
    """The publishers of a node, by topic; messages are given as bytes.

    Args:
        node: the node.
        topics: what it publishes besides /diagnostics.
    """

    def __init__(self, node: Node, topics: Iterable[str]):
        self._node = node
        self._publishers = {topic: node.create_publisher(qos.message_class(topic), topic, qos.sent(topic)) for topic in topics}
        self._sent = 0
        self._patient = True

    def send(self, topic: str, raw: bytes) -> None:
        """Publish the CDR bytes of a message."""
        self._publishers[topic].publish(raw)

    def recorder_listens(self) -> bool:
        """Whether a recorder listens to all of them, and will get all that is sent from now on."""
        for topic, publisher in self._publishers.items():
            known = self._node.get_subscriptions_info_by_topic(topic)
            if not any(end.node_name == RECORDER for end in known) or publisher.get_subscription_count() < len(known):
                return False
        return True

    def keep_pace(self) -> None:
        """Once per period where nothing may be lost: let listeners catch up before the oldest message kept would be overwritten."""
        self._sent += 1
        if self._sent % _ACKED_EVERY == 0:
            # One that did not catch up, such as a dead one that the middleware still counts, is not waited for again.
            self._patient = self.settle(_ACKED_WAIT_S if self._patient else 0.0)

    def settle(self, seconds: float) -> bool:
        """Wait until every listener has everything; whether that came true in time."""
        deadline = monotonic() + seconds
        for publisher in self._publishers.values():
            # A long wait can miss the acknowledgement and then lasts to the next heartbeat; many short ones do not.
            while not publisher.wait_for_all_acked(_ACKED_STEP):
                if monotonic() > deadline:
                    return False
        return True


class Diagnostics:
    """Publishes a node's health once a second of wall time."""

    def __init__(self, node: Node):
        self.health = Health(_log(node))
        self._name = node.get_fully_qualified_name().lstrip("/")
        self._publisher = node.create_publisher(DiagnosticArray, Topic.DIAGNOSTICS, qos.sent(Topic.DIAGNOSTICS))
        self._due = 0.0

    def tick(self, time_ns: int, report: Callable[[], None]) -> None:
        """Publish if a second has passed, stamped with sim time; `report` brings the figures up to date before."""
        if monotonic() < self._due:
            return
        self._due = monotonic() + _DIAGNOSTICS_S
        report()
        level, message, values = self.health.status()
        status = DiagnosticStatus(level=bytes([level]), name=self._name, message=message, hardware_id="hamr")
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        array = DiagnosticArray(status=[status])
        array.header.stamp = Time(sec=time_ns // 10**9, nanosec=time_ns % 10**9)
        self._publisher.publish(array)


def _log(node: Node) -> Callable[[Level, str], None]:
    logger = node.get_logger()

    def log(level: Level, sentence: str) -> None:
        # rclpy binds a severity to the line that logs.
        if level == Level.OK:
            logger.info(sentence)
        elif level == Level.WARN:
            logger.warning(sentence)
        else:
            logger.error(sentence)

    return log
