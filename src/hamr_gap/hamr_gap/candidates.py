"""Every effect at every place that a machine and a run can show."""

from __future__ import annotations

from itertools import combinations

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import Machine

from .parameters import Candidate


def candidates(machine: Machine, channels: tuple[str, ...]) -> list[Candidate]:
    """All that can be named: each form at each joint and at all joints, coupling forms once."""
    joints = range(len(machine.joints))
    sets = [s for size in range(1, len(machine.joints) + 1) for s in combinations(joints, size)]
    found = []
    for name, form in machine.forms:
        if not library()[name].smooth or missing(name, machine, channels):
            continue
        found += [Candidate(name, form.name, s) for s in ([tuple(joints)] if form.acts == "pair" else sets)]
    return found


def missing(effect: str, machine: Machine, channels: tuple[str, ...]) -> str:
    """Why a suspended run with these channels cannot show an effect; empty if it can."""
    needs = library()[effect].needs
    if "ground" in needs:
        return "the machine does not touch the ground"
    if "deflections" in needs and len(channels) <= len(machine.joints):
        return "there is no sensor on the actuator's side"
    if "unnamed" in needs:
        return "it is no name"
    return ""
