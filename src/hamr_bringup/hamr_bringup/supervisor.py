"""Runs a graph as processes: one supervisor, no restarts, one way out."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Thread
from time import monotonic, sleep

from hamr_description.errors import HamrError

from .executables import executables
from .graph import NodeSpec, Run, graph

_POLL_S = 0.02
#: After which the nodes but the recorder are told to end, then the recorder too, then everyone is killed.
_HURRY_S, _PATIENCE_S = (0.7, 0.9, 1.8), (4.0, 5.0, 15.0)
_DOMAINS = 101  # whose ports stay clear of the system's


class NodeFailed(HamrError):
    """A node refused to start or to go on; the message is its own."""


class Child:
    """A node process; what it says goes to standard error, line by line under its name."""

    def __init__(self, spec: NodeSpec, environment: dict[str, str]):
        self.spec = spec
        self.last_line = ""
        module = executables()[spec.package, spec.executable]
        self.process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.child", str(os.getpid()), module, *spec.arguments()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=environment,
            process_group=0,  # a Ctrl-C of the terminal reaches the supervisor alone
        )
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        for line in self.process.stdout:
            self.last_line = line.strip() or self.last_line
            sys.stderr.write(f"{self.spec.name:14} | {line}")

    @property
    def status(self) -> int | None:
        """Exit status, negative for the signal that killed it; None while it runs."""
        return self.process.poll()

    def interrupt(self) -> None:
        """Ask the node to end."""
        if self.status is None:
            self.process.send_signal(signal.SIGINT)

    def finish(self) -> int:
        """Kill what still runs; all that was said is out afterwards."""
        if self.status is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdout.close()
        return self.process.returncode


def up(run: Run) -> dict:
    """Run the graph until its simulator ends, Ctrl-C, or a node refuses to go on.

    A node that is killed by a signal is reported and the others go on: they hold the robot safe, and it may be started again by hand
    in the same ROS domain.

    Returns:
        domain: ROS domain id; nodes: exit status of each; and what the simulator reports: simulated_s, wall_s, real_time_factor, counts.

    Raises:
        NodeFailed: with the node's own sentence.
    """
    with tempfile.TemporaryDirectory(prefix="hamr-") as folder, _interruptible() as interrupted:
        report = Path(folder, "report.json")
        specs = [_reporting(spec, report) if spec.ends_run else spec for spec in graph(run)]
        environment = _environment()
        sys.stderr.write(f"ROS_DOMAIN_ID={environment['ROS_DOMAIN_ID']}: {', '.join(spec.name for spec in specs)}\n")
        children = [Child(spec, environment) for spec in specs]
        try:
            _watch(children, interrupted)
        finally:
            _end(children, _HURRY_S if interrupted else _PATIENCE_S)
            statuses = {child.spec.name: child.finish() for child in children}
        for child in children:
            if statuses[child.spec.name] > 0:
                raise NodeFailed(child.last_line or f"{child.spec.name} ended with status {statuses[child.spec.name]}.")
        figures = json.loads(report.read_text()) if report.exists() else {}
        return {"domain": int(environment["ROS_DOMAIN_ID"]), "nodes": statuses, **figures}


def _reporting(spec: NodeSpec, report: Path) -> NodeSpec:
    return replace(spec, parameters={**spec.parameters, "report": str(report)})


def _environment() -> dict[str, str]:
    own = {
        "ROS_DOMAIN_ID": str(1 + os.getpid() % _DOMAINS),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "RCUTILS_CONSOLE_OUTPUT_FORMAT": "{severity}: {message}",
        "PYTHONUNBUFFERED": "1",
    }
    return {**own, **os.environ}


@contextmanager
def _interruptible() -> Iterator[list[int]]:
    """A list that is empty until SIGINT or SIGTERM comes; the second one changes nothing."""
    came: list[int] = []
    before = {number: signal.signal(number, lambda number, _: came.append(number)) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _watch(children: Sequence[Child], interrupted: Sequence[int]) -> None:
    """Until the run is over."""
    known: set[str] = set()
    while not interrupted:
        for child in children:
            status = child.status
            if status is None or child.spec.name in known:
                continue
            if child.spec.ends_run or status > 0:
                return
            known.add(child.spec.name)
            how = f"was killed by signal {-status}" if status < 0 else "ended"
            sys.stderr.write(f"{child.spec.name} {how}; the others go on without it.\n")
        sleep(_POLL_S)


def _end(children: Sequence[Child], grace_s: tuple[float, float, float]) -> None:
    """The simulator ends first, so that its last period has voltages; the recorder last, so that it hears everyone's last messages."""
    began = monotonic()
    simulators = [child for child in children if child.spec.ends_run]
    recorders = [child for child in children if child.spec.executable == "recorder"]
    others = [child for child in children if child not in simulators + recorders]
    for group, until in ((simulators, grace_s[0]), (others, grace_s[1]), (recorders, grace_s[2]), (children, grace_s[2])):
        for child in group:
            child.interrupt()
        while _running(group) and monotonic() - began < until:
            sleep(_POLL_S)


def _running(children: Iterable[Child]) -> bool:
    return any(child.status is None for child in children)
