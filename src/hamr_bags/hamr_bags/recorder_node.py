"""The node recorder: everything on the topics of this robot into one bag, stamped with sim time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from time import monotonic

from rclpy.node import Node

from hamr_controller.health import Health
from hamr_controller.ros import qos
from hamr_controller.ros.parameters import parameter
from hamr_controller.ros.ports import Diagnostics
from hamr_controller.ros.process import SLICE_S, Spinner, run_node
from hamr_controller.ros.run import RECORDER
from hamr_description.errors import BagError, ConfigError
from hamr_description.names import Topic
from hamr_description.rates import TARGET_NS

from .cdr import stamp_ns
from .recorder import Recorder
from .topics import SERVO, TYPES

#: Topics with one message a period; what comes twice with one stamp was sent again, not measured again.
PERIODIC = frozenset({Topic.CLOCK, Topic.JOINT_STATES, Topic.ODOM, Topic.LEG_TARGETS, *SERVO})
_QUIET_S, _DRAIN_S = 0.2, 1.0  # wall time: what is still under way when the run ends comes within


@dataclass(frozen=True, slots=True)
class Parameters:
    """Parameters of the recorder."""

    bag: str = parameter("", "folder of the bag, which must not exist yet")

    def __post_init__(self) -> None:
        if not self.bag:
            raise ConfigError("The recorder has no parameter bag; name the folder of the bag.")


class Tape:
    """Hands each message on to the recorder once, and counts what is missing."""

    def __init__(self, recorder: Recorder, health: Health):
        self._recorder, self._health = recorder, health
        self._last: dict[str, int] = {}
        self.heard_at = monotonic()

    @property
    def time_ns(self) -> int:
        """Newest sim time seen."""
        return self._last.get(Topic.CLOCK, 0)

    def hear(self, topic: str, raw: bytes) -> None:
        """A message came."""
        self.heard_at = monotonic()
        try:
            if topic in PERIODIC:
                self._periodic(topic, raw)
            else:
                self._recorder.write(topic, raw, self._last.get(Topic.CLOCK))
        except BagError as error:
            self._health.refuse(str(error))

    def _periodic(self, topic: str, raw: bytes) -> None:
        stamp = stamp_ns(raw, TYPES[topic])
        last = self._last.get(topic)
        if stamp == last:
            return
        self._recorder.write(topic, raw, stamp)
        self._last[topic] = stamp
        self._health.counts[f"{topic} messages"] += 1
        if last is not None and stamp > last + TARGET_NS:
            self._health.counts[f"{topic} periods missing"] += (stamp - last) // TARGET_NS - 1


class RecorderNode:
    """Wires a Tape to all topics."""

    def __init__(self, node: Node, parameters: Parameters, spinner: Spinner):
        self._spinner = spinner
        self._recorder = Recorder(parameters.bag)
        self._diagnostics = Diagnostics(node)
        self._tape = Tape(self._recorder, self._diagnostics.health)
        for topic in TYPES:
            node.create_subscription(qos.message_class(topic), topic, partial(self._tape.hear, topic), qos.recorded(topic), raw=True)
        node.get_logger().info(f"Recording to {parameters.bag}.")

    def run(self) -> None:
        """Record until the process is to stop; the bag is whole in any case."""
        try:
            while not self._spinner.stopping:
                self._spinner.once(SLICE_S)
                self._diagnostics.tick(self._tape.time_ns, lambda: None)
        finally:
            self.finish()

    def finish(self) -> None:
        """Record what is still under way and close the bag."""
        ended = monotonic()
        while monotonic() < min(max(ended, self._tape.heard_at) + _QUIET_S, ended + _DRAIN_S):
            self._spinner.once(_QUIET_S)
        self._recorder.close()


make = RecorderNode


def main() -> None:
    """The executable."""
    run_node(RECORDER, Parameters, make)


if __name__ == "__main__":
    main()
