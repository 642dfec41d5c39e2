"""Every effect at every place that a machine and a run can show."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import Machine

from ..data.record import Record
from ..fitting.parameters import Candidate

AIRBORNE = "the machine does not touch the ground"


def candidates(machine: Machine, record: Record) -> list[Candidate]:
    """All that can be named: each form at each joint and at all joints, those of a drive where it changes, those of a coordinate's
    sensor where there is one, coupling forms once."""
    joints = range(len(machine.joints))
    sets = [s for size in range(1, len(machine.joints) + 1) for s in combinations(joints, size)]
    driven = [s for s in sets if record.driven[list(s)].all()]
    read = [s for s in sets if all(machine.channels[j] in record.channels for j in s)]
    found = []
    for name, form in machine.forms:
        if not library()[name].smooth or missing(name, machine, record):
            continue
        places = [tuple(joints)] if form.acts == "pair" else {"drive": driven, "sense": read}.get(form.acts, sets)
        found += [Candidate(name, form.name, s) for s in places]
    return found


def of_one_size(everything: Iterable[Candidate]) -> list[Candidate]:
    """Of each effect at each joint, and between two, the first form that has one size: the simplest, which stands for the name where it
    is said how large an effect would have shown."""
    first: dict[tuple, Candidate] = {}
    for c in everything:
        if len(c.law.sizes) == len(c.places) == 1:
            first.setdefault(c.name, c)
    return list(first.values())


def missing(effect: str, machine: Machine, record: Record) -> str:
    """Why a suspended run cannot show an effect; empty if it can."""
    needs = library()[effect].needs
    if "ground" in needs:
        return AIRBORNE
    if not record.driven.any() and all(form.acts == "drive" for form in library()[effect].forms):
        return "no drive ever changes"
    if "deflections" in needs and all(machine.motion_of(channel) for channel in record.channels):
        return "there is no sensor on the actuator's side"
    read = set(machine.channels[: len(machine.joints)]) & set(record.channels)
    if not read and all(form.acts == "sense" for form in library()[effect].forms):
        return "no sensor reads a coordinate"
    if "unnamed" in needs:
        return "it is no name"
    return ""
