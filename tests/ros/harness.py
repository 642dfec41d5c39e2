"""A graph of real node processes in a ROS domain of its own, and an observer on its topics. Waits are for conditions."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from hamr_bags.bag import open_bag
from hamr_bags.recorder_node import PERIODIC
from hamr_bringup.executables import executables
from hamr_bringup.graph import NodeSpec
from hamr_controller.ros import qos
from hamr_description.names import Topic

LIMIT_S = 40.0  # only what never comes waits this long
STAND_INS = Path(__file__).with_name("stand_ins.py")


def until(condition: Callable[[], object], what: str, meanwhile: Callable[[], None] = lambda: sleep(0.02)):
    """The first true value of a condition."""
    deadline = monotonic() + LIMIT_S
    while monotonic() < deadline:
        if value := condition():
            return value
        meanwhile()
    raise AssertionError(f"never: {what}")


class Process:
    """A node process; what it says goes to a file."""

    def __init__(self, command: list[str], log: Path):
        self._log = log
        with log.open("ab") as file:
            self.popen = subprocess.Popen(command, stdout=file, stderr=file, process_group=0)

    @property
    def said(self) -> str:
        return self._log.read_text(errors="replace")

    def ended(self) -> int:
        """Exit status, once it has ended."""
        until(lambda: self.popen.poll() is not None, f"end of {self._log.stem}: {self.said}")
        return self.popen.returncode

    def signal(self, number: int) -> Process:
        self.popen.send_signal(number)
        return self

    def kill(self) -> None:
        self.popen.kill()
        self.popen.wait()


class Graph:
    """Starts node processes: the real ones, but for the toy plant and the formula as policy."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._processes: list[Process] = []

    def start(self, name: str, **parameters: object) -> Process:
        """simulator, leg_controller, policy, excitation or recorder."""
        package = {"leg_controller": "hamr_controller", "policy": "hamr_policy"}.get(name, "hamr_bags")
        return self.start_spec(NodeSpec(package, name, name, parameters))

    def start_spec(self, spec: NodeSpec, *more: str) -> Process:
        if spec.name in ("simulator", "policy"):
            command = [sys.executable, str(STAND_INS), spec.name]
        else:
            command = [sys.executable, "-m", executables()[spec.package, spec.executable]]
        return self.run(spec.name, *command, *spec.arguments(), *more)

    def run(self, name: str, *command: str) -> Process:
        self._processes.append(Process(list(command), self.folder / f"{name}-{len(self._processes)}.log"))
        return self._processes[-1]

    def close(self) -> None:
        for process in self._processes:
            process.kill()


class Observer:
    """Listens to topics and keeps all messages."""

    def __init__(self, *topics: str):
        self._context = rclpy.Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node("observer", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.heard: dict[str, list] = defaultdict(list)
        self._newest: dict[str, list] = {}
        for topic in topics:
            self.node.create_subscription(qos.message_class(topic), topic, self.heard[topic].append, qos.sent(topic))

    def spin(self) -> None:
        self._executor.spin_once(timeout_sec=0.02)

    def until(self, condition: Callable[[], object], what: str):
        return until(condition, what, self.spin)

    def next(self, topic: str, fits: Callable[[object], bool] = lambda message: True):
        """The next message of a topic that fits; what came before is forgotten."""
        self.heard[topic].clear()
        return self.until(lambda: next((m for m in self.heard[topic] if fits(m)), None), f"a message on {topic}")

    def newest(self, topic: str):
        """A message that has waited behind no other, as control nodes hear it: whoever acts on an older one is stale on a busy machine."""
        if topic not in self._newest:
            self._newest[topic] = []
            self.node.create_subscription(qos.message_class(topic), topic, self._newest[topic].append, qos.heard(topic))
        self._newest[topic].clear()
        self.until(lambda: self._newest[topic], f"a message on {topic}")
        return self._newest[topic][-1]

    def status(self, node: str, fits: Callable[[object], bool] = lambda status: True):
        """The next status of a node in /diagnostics that fits."""
        message = self.next(Topic.DIAGNOSTICS, lambda m: m.status[0].name == node and fits(m.status[0]))
        return message.status[0]

    def call(self, kind: type, service: str, request: object):
        """Call a service and wait for the response."""
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready, service)
        future = client.call_async(request)
        self.until(future.done, f"response of {service}")
        self.node.destroy_client(client)
        return future.result()

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)


def domain_lock(folder: Path) -> tuple[int, int]:
    """A ROS domain that no other test has, and the descriptor that holds it."""
    folder.mkdir(exist_ok=True)
    for domain in range(1, 102):
        descriptor = os.open(folder / str(domain), os.O_CREAT | os.O_RDWR)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return domain, descriptor
        except BlockingIOError:
            os.close(descriptor)
    raise AssertionError("all ROS domains are taken")


def contents(bag: Path) -> dict[str, list[tuple[int, bytes]]]:
    """Stamps and bytes of all messages of the periodic topics."""
    found: dict[str, list[tuple[int, bytes]]] = {}
    with open_bag(bag) as opened:
        for message in opened.messages():
            if message.topic in PERIODIC:
                found.setdefault(message.topic, []).append((message.log_ns, bytes(message.raw)))
    return {topic: sorted(messages) for topic, messages in found.items()}
