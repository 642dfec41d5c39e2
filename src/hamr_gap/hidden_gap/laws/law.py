"""What a law is, and the registry of all of them.

A law is a compiled function `(i, t, dt, w, p, s)` called before every step, once per joint i (0 swing, 1 lift) of its place:
t and dt in ms, `w` the workspace shared with the loop, `p` its parameters in the order of their ranges, `s` its own state, zero at first.
The workspace holds pairs (swing, lift): what a law may read, and what it adds to or overwrites.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import cfunc, types

#: Read: hip angle rad, rate rad/ms; actuator-side angle and rate; command before any law, V about neutral; torque per volt.
Q, V, RQ, RV, COMMAND, GAIN = 0, 2, 4, 6, 8, 10
#: Write: effective drive voltage about neutral, torque on the leg and on the actuator side (N mm), inertia added (g mm^2), tip (mm).
U, TAU, RTAU, ARMATURE, TIP = 12, 14, 16, 18, 20
SIZE = 22

SWING, LIFT, BOTH = (0,), (1,), (0, 1)
EACH = (SWING, LIFT)
ANY = (SWING, LIFT, BOTH)
_F8 = types.CPointer(types.float64)
SIGNATURE = types.void(types.intp, types.float64, types.float64, _F8, _F8, _F8)


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """A formula for a family.

    Attributes:
        family, name: name is unique.
        ranges: parameter -> (low, high); drawn log-uniformly where low > 0, else uniformly.
        size: the parameter that is scaled until the strength is met; grows with the effect.
        places: joint sets it makes sense at.
        states: numbers of state per joint, or a function of (parameters, step) that gives it.
        step: integration step, ms.
        machine: "", "series" (own hinge for the actuator) or "coupled" (its size is an inertia of both joints).
        sensor: acts on the sampled angle and not in the loop.
        prepare: (parameters, step) -> numbers the compiled law gets; None passes the parameters in their order.
    """

    family: str
    name: str
    function: Callable
    ranges: Mapping[str, tuple[float, float]]
    size: str
    places: tuple[tuple[int, ...], ...]
    states: int | Callable
    step: float
    machine: str
    sensor: bool
    prepare: Callable | None

    def numbers(self, parameters: Mapping[str, float], dt: float) -> np.ndarray:
        """What the compiled law gets as `p`."""
        if self.prepare is not None:
            return np.asarray(self.prepare(parameters, dt), float)
        return np.array([parameters[name] for name in self.ranges], float)

    def count(self, parameters: Mapping[str, float], dt: float) -> int:
        """States per joint."""
        return self.states(parameters, dt) if callable(self.states) else self.states


LAWS: dict[str, Law] = {}


def law(
    family: str,
    *,
    size: str,
    places: tuple = EACH,
    states: int | Callable = 0,
    step: float = 0.025,
    machine: str = "",
    sensor: bool = False,
    prepare: Callable | None = None,
    **ranges: tuple[float, float],
) -> Callable[[Callable], Callable]:
    """Register a function as a law of a family under its own name."""

    def register(function: Callable) -> Callable:
        name = function.__name__
        assert name not in LAWS and size in ranges
        LAWS[name] = Law(family, name, function, ranges, size, places, states, step, machine, sensor, prepare)
        return function

    return register


@cache
def address(name: str) -> int:
    """Where the compiled law lies; compiled on first use, so that a case pays for its own laws only."""
    compiled = cfunc(SIGNATURE)(LAWS[name].function)
    _KEEP.append(compiled)
    return compiled.address


_KEEP: list = []
