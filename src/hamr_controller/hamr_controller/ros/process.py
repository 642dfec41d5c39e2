"""The frame of every node process: signals, start, one-sentence failures, orderly end."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import NoReturn, Protocol, TypeVar

import rclpy
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from hamr_description.errors import ConfigError, HamrError

from . import middleware, parameters

P = TypeVar("P")
SLICE_S = 0.05  # longest stay in the executor; a signal is noticed after it
_USAGE = "write --ros-args -p name:=value, or --ros-args --params-file FILE"
_PR_SET_TIMERSLACK = 29
_SIG_IGN = ctypes.c_void_p(1)  # signal.h


class Runnable(Protocol):
    """What a node does, until `spinner.stopping`."""

    def run(self) -> None: ...


class Spinner:
    """Runs the callbacks of a process's nodes, and knows when it is time to stop.

    The process has one thread of its own: callbacks run inside `once` and nowhere else.
    """

    def __init__(self, executor: Executor):
        self._executor = executor
        self.stopping = False

    def once(self, seconds: float = 0.0) -> None:
        """Run what is due; wait up to so many s (at most SLICE_S) for the first."""
        # Without a limit this executor of rclpy 7.1.6 spins forever, runs nothing and ignores signals.
        self._executor.spin_once(timeout_sec=min(seconds, SLICE_S))

    def add(self, node: Node) -> None:
        """Run a node's callbacks too."""
        self._executor.add_node(node)

    def stop(self, *_: object) -> None:
        """Signal handler: end after the present step. A second signal changes nothing."""
        self.stopping = True


@contextmanager
def spinning() -> Iterator[Spinner]:
    """A spinner of this process, with rclpy started and SIGINT and SIGTERM caught; on leaving, everything is taken down in order."""
    # Timers of a thread fire up to 50 us late by default; here that is paid several times in every period.
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    middleware.configure()
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    executor = EventsExecutor()
    spinner = Spinner(executor)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, spinner.stop)
    try:
        yield spinner
    finally:
        # A signal while the executor goes down would abort the process. The kernel is told, not Python: signal.signal(..., SIG_IGN)
        # prints an exception when a signal that came just before is still to be handled.
        for number in (signal.SIGINT, signal.SIGTERM):
            ctypes.CDLL(None).signal(number, _SIG_IGN)
        nodes = executor.get_nodes()
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()


def new_node(name: str, kind: type[P], given: Mapping[str, object] = MappingProxyType({})) -> tuple[Node, P]:
    """A node with its parameters as `parameters.load` reads them; `given` ones count like those of the command line."""
    overrides = [Parameter(key, value=value) for key, value in given.items()]
    node = Node(name, parameter_overrides=overrides, automatically_declare_parameters_from_overrides=True)
    return node, parameters.load(node, kind, sys.argv)


def run_node(name: str, kind: type[P], make: Callable[[Node, P, Spinner], Runnable]) -> NoReturn:
    """The main function of a node executable; the exit status is 1, after one sentence, if the user's input does not fit.

    Args:
        name: node name unless remapped.
        kind: dataclass of the parameters.
        make: gives the node what it does.
    """
    status = 0
    try:
        _check(sys.argv)
        with spinning() as spinner:
            node, values = new_node(name, kind)
            spinner.add(node)
            make(node, values, spinner).run()
    except HamrError as error:
        sys.stderr.write(f"{name}: {error}\n")
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    # Everything is closed. What is left, taking the compiled code apart, lasts up to a second, in which Ctrl-C would seem to do nothing.
    os._exit(status)


def _check(arguments: Sequence[str]) -> None:
    """ConfigError if ROS cannot read the arguments, or some are not for ROS."""
    try:
        foreign = remove_ros_args(list(arguments))[1:]
    except RuntimeError as error:  # rclpy's own are not public
        what = str(error).removeprefix("Failed to parse ROS arguments: ").split(", at /")[0]
        raise ConfigError(f"ROS cannot read the arguments: {what}; {_USAGE}.") from None
    if foreign:
        raise ConfigError(f"There is no argument '{foreign[0]}'; {_USAGE}.")
