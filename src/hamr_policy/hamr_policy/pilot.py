"""What the policy node does without ROS: commands and states in, target hip angles out."""

from __future__ import annotations

from collections.abc import Mapping
from math import copysign, isfinite
from typing import Protocol

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_NS

from .task import TASKS

_STAND = np.zeros(len(JOINTS))
_STAND.setflags(write=False)


class Runtime(Protocol):
    """A loaded policy; `task` is the name of what it can do."""

    task: str

    def reset(self) -> None:
        """A primitive begins at the next state."""

    def act(self, sample: np.ndarray, base: np.ndarray, command: int) -> np.ndarray:
        """Targets (8,) rad for a state (7, 8), (13,) SI and a direction +1 or -1."""


def command_named(name: str) -> tuple[str, int] | None:
    """(task, direction) by the name of the direction, None for the empty name; ConfigError lists the names."""
    known = {name: (task.name, sign) for task in TASKS.values() for sign, name in task.directions.items()}
    if name and name not in known:
        raise ConfigError(f"There is no command '{name}'; choose one of {', '.join(known)}, or none.")
    return known.get(name)


def load(files: str) -> dict[str, Runtime]:
    """Policies by name of their task.

    Args:
        files: policy files, with commas.

    Raises:
        ModelError: a file does not fit this robot.
        ConfigError: two of them are for one task.
    """
    policies: dict[str, Runtime] = {}
    for file in filter(None, (name.strip() for name in files.split(","))):
        from .runtime import PolicyRuntime  # onnxruntime only where a policy is run

        policy = PolicyRuntime(file)
        if policy.task in policies:
            raise ConfigError(f"{file} is a second policy for '{policy.task}'; give one for each task.")
        policies[policy.task] = policy
    return policies


class Pilot:
    """Answers states with target hip angles; stands still (all targets 0) unless told otherwise.

    Args:
        policies: by name of their task.
        silence_s: sim time after which a command that is not repeated counts as zero.
        command: (task, direction) that holds until a command comes; None to stand.
    """

    def __init__(self, policies: Mapping[str, Runtime], *, silence_s: float, command: tuple[str, int] | None = None):
        if command is not None and command[0] not in policies:
            raise ConfigError(f"The command needs a policy for '{command[0]}', but {_loaded(policies)}.")
        self._policies, self._silence_ns = policies, round(silence_s * 1e9)
        self._command, self._until = command, None
        self._active: tuple[str, int] | None = None
        self._time_ns = -1

    def command(self, forward: float, turn: float) -> None:
        """A command came: the signs of forward speed and turning rate count.

        Raises:
            ConfigError: what it asks for cannot be done; the robot then stands.
        """
        self._command, self._until = None, self._time_ns + self._silence_ns
        if not (isfinite(forward) and isfinite(turn)):
            raise ConfigError(f"{Topic.CMD_VEL} has linear.x {forward} and angular.z {turn}; send finite numbers.")
        if forward and turn:
            raise ConfigError(f"{Topic.CMD_VEL} asks to walk and turn at once; leave linear.x or angular.z at 0.")
        if forward or turn:
            task = "walk" if forward else "turn"
            if task not in self._policies:
                raise ConfigError(f"{Topic.CMD_VEL} needs a policy for '{task}', but {_loaded(self._policies)}.")
            self._command = task, int(copysign(1, forward or turn))

    def answer(self, time_ns: int, sample: np.ndarray, base: np.ndarray) -> np.ndarray:
        """Targets (8,) rad for the state of a time: (7, 8) of which hip angles and rates are used, and (13,), SI.

        A cut in time, and a new command, begin a primitive anew.
        """
        cut = time_ns != self._time_ns + TARGET_NS
        self._time_ns = time_ns
        if self._until is not None and not self._until - self._silence_ns <= time_ns <= self._until:  # before it: a new simulator
            self._command = None
        begins = cut or self._command != self._active
        self._active = self._command
        if self._active is None:
            return _STAND
        task, direction = self._active
        if begins:
            self._policies[task].reset()
        return self._policies[task].act(sample, base, direction)


def _loaded(policies: Mapping[str, Runtime]) -> str:
    return f"only '{', '.join(policies)}' is loaded" if policies else "no policy is loaded"
