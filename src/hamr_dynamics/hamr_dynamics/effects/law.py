"""What an effect is: a named physical law with parameters, acting at one place of a machine, off when its sizes are zero.

A law is a pure function over any scalar type (floats, arrays, traced scalars), written once; kernels, fits and reports all run
it. It sees its surroundings as one of the views below and answers with what changes. Dimensions are products of powers of F
(generalised force), Q (coordinate), T (time) and U (drive), so that one library serves machines of any units; S is a time that is
usual for a whole run, and effects of the whole robot on the ground have N (force), L (length) and M (mass) besides.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

#: The parts of a machine in which effects act.
PARTS = ("actuator", "transmission", "body", "contact", "sensor")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a law.

    Attributes:
        name: as in effect files. dimension: such as "F", "F/Q^3", "T" or "1".
        typical: prior median, in the machine's scales (`Scales`). low, high: bounds, likewise.
        doc: what it is.
        shape: False for a size (the effect is linear in it to first order, and off where all sizes are zero), True for any other.
        screen: values of a shape to screen with, in the machine's scales; of a size only where a threshold makes small ones do nothing.
        by: of a size, names of the shapes that it hangs on; all of the form's if not given.
    """

    name: str
    dimension: str
    typical: float
    low: float
    high: float
    doc: str
    shape: bool = False
    screen: tuple[float, ...] = ()
    by: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Scales:
    """What is usual on a machine: generalised force F, coordinate Q, time T (coordinate over its rate), drive U, length of a run S."""

    force: float
    coordinate: float
    time: float
    drive: float
    span: float

    def of(self, dimension: str) -> float:
        """Scale of a dimension: of("F/Q^3") is force / coordinate^3."""
        scales = {"F": self.force, "Q": self.coordinate, "T": self.time, "U": self.drive, "S": self.span}
        total = 1.0
        for letter, power in powers(dimension):
            total *= scales[letter] ** power
        return total


def powers(dimension: str) -> list[tuple[str, int]]:
    """A dimension as (letter, power): powers("F/Q^3") is [("F", 1), ("Q", -3)]."""
    found, sign = [], 1
    for token in re.findall(r"[A-Z1](?:\^\d)?|/|\*", dimension):
        if token in "*/":
            sign = -1 if token == "/" else 1
        elif token != "1":
            found.append((token[0], sign * int(token[2:] or 1)))
    return found


@dataclass(frozen=True, slots=True)
class Input:
    """A joint's drive as commanded: u, the drives of all joints, time, step."""

    u: object
    all: tuple
    own: int
    time: object
    step: object


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint in the middle of a step, at the rates of its start.

    Attributes:
        q, v: coordinate and rate. drive: generalised force of the drive. stiffness, inertia: the machine's own at rest (constants).
        time, step: T. damping: of the joint there, with all that acts before.
    """

    q: object
    v: object
    drive: object
    stiffness: object
    inertia: object
    time: object
    step: object
    damping: object


@dataclass(frozen=True, slots=True)
class Push:
    """What an effect adds at a joint.

    Attributes:
        force. stiffness, damping: -d force/dq and -d force/dv, for the implicit step; damping exact where it is smooth.
        mass: added inertia. slip: by how much the actuator's side runs ahead of the joint (what a tip sensor sees besides).
    """

    force: object = 0.0
    stiffness: object = 0.0
    damping: object = 0.0
    mass: object = 0.0
    slip: object = 0.0


@dataclass(frozen=True, slots=True)
class Pair:
    """Both joints of a leg, as `Joint`, in tuples of two."""

    q: tuple
    v: tuple
    drive: tuple
    stiffness: tuple
    inertia: tuple
    step: object


@dataclass(frozen=True, slots=True)
class PairPush:
    """What an effect adds to a leg: force and slip (2,), and mass, stiffness and damping as (11, 12, 22)."""

    force: tuple = (0.0, 0.0)
    mass: tuple = (0.0, 0.0, 0.0)
    stiffness: tuple = (0.0, 0.0, 0.0)
    damping: tuple = (0.0, 0.0, 0.0)
    slip: tuple = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Signal:
    """A sensor's reading: y, its full scale (constant), step."""

    y: object
    step: object


@dataclass(frozen=True, slots=True)
class Foot:
    """A foot's contact: friction coefficient, stiffness N/L, damping N T/L."""

    friction: object
    stiffness: object
    damping: object


@dataclass(frozen=True, slots=True)
class Chassis:
    """The chassis without its legs, in its own axes about base_link: mass M, com (3,) L, inertia about it (6,) M L^2 (xx yy zz xy xz yz);
    gravity (3,) L/T^2 as the ground's axes see it, for the whole robot."""

    mass: object
    com: tuple
    inertia: tuple
    gravity: tuple


@dataclass(frozen=True, slots=True)
class Motion:
    """Position (3,) L and velocity (3,) L/T of base_link in the ground's axes."""

    position: tuple
    velocity: tuple


@dataclass(frozen=True, slots=True)
class Form:
    """One formula for a name.

    Attributes:
        name. acts: "drive", "force", "pair" or "sense" (and four more below), which fixes the views:
            drive: (Input, p, z) -> (u, z);  force: (Joint, p, z) -> (Push, z);  pair: (Pair, p, z) -> (PairPush, z);
            sense: (Signal, p, z) -> (y, z).
            Of the whole robot on the ground, and unknown to machines: "foot" and "chassis", which run once, before the first step,
            "leg" and "tow", which run in every step:
            foot: (Foot, p, z) -> (Foot, z);  chassis: (Chassis, p, z) -> (Chassis, z);  leg: (`leg.Leg`, p, z) -> (Leg, z);
            tow: (Motion, p, z) -> (force (3,) N at base_link in the ground's axes, z).
        law: with p a mapping of parameters and z the tuple of internal states, both for this place.
        parameters. states: how many internal states, 0 at rest.
        order: where it comes among those that act on the same signal, from command to force or from joint to reading.
    """

    name: str
    acts: str
    law: Callable
    parameters: tuple[Parameter, ...]
    states: int = 0
    order: int = 0

    @property
    def sizes(self) -> tuple[Parameter, ...]:
        """Parameters that are zero when the effect is off."""
        return tuple(p for p in self.parameters if not p.shape)

    @property
    def shapes(self) -> tuple[Parameter, ...]:
        """The other parameters."""
        return tuple(p for p in self.parameters if p.shape)


@dataclass(frozen=True, slots=True)
class Effect:
    """A name with its forms.

    Attributes:
        name, part (of `PARTS`), summary: one sentence. forms: in order of simplicity.
        contains: names that this one holds as a special case. mimics: names no wider that it can be taken for, beside a re-tune.
        same_as: other name -> the condition under which no data tell them apart.
        needs: why a run may not show it at all: "ground", "deflections", "closed loop", "hold"; empty for any run.
        smooth: whether readings change little by little with its sizes, so that derivatives lead to them.
        experiment: what shows it best. source: where the law and its size come from.
    """

    name: str
    part: str
    summary: str
    forms: tuple[Form, ...]
    experiment: str
    source: str
    contains: tuple[str, ...] = ()
    mimics: tuple[str, ...] = ()
    same_as: Mapping[str, str] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    smooth: bool = True

    def form(self, name: str) -> Form:
        """The form of a name; KeyError if there is none."""
        return {form.name: form for form in self.forms}[name]
