"""Effects of a file into the parameters of simulated robots."""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import AXES, LEGS

from .bank_stages import LEG_BANK, USUAL
from .effects.bank import CHANGES
from .effects.effects_file import EffectsFile, PlacedEffect
from .effects.law import Chassis, Foot
from .effects.si import si_factor
from .machine import leg_machine

if TYPE_CHECKING:
    from .batch import BatchSim
    from .plant import Plant

_FOOT = ("friction", "contact_stiffness", "contact_damping")


def neutral_leg(plant: Plant, leg: str, gravity: float) -> dict[str, float]:
    """More lane parameters of a leg, with every effect off."""
    rest = leg_machine(plant, leg, gravity=gravity).at_rest
    own = {"stiffness": rest.stiffness, "inertia": rest.mass}
    rows = {f"rest_{name}.{j}": float(matrix[2 * j]) for name, matrix in own.items() for j in range(len(AXES))}
    return rows | dict(zip(LEG_BANK.parameter_rows, LEG_BANK.neutral(USUAL), strict=True))


def set_effects(sim: BatchSim, effects: EffectsFile) -> None:
    """Switches effects on, in all robots of a fresh BatchSim whose plant carries the bank.

    Raises:
        ConfigError: a change leaves no stiffness or inertia.
    """
    for placed in effects.effects:
        acts = placed.law.acts
        if acts == "foot":
            _set_feet(sim, placed)
        elif acts == "chassis":
            _set_chassis(sim, placed)
        elif acts == "tow":
            for name, value in inside(placed).items():
                sim.set_body(f"{placed.effect}.{placed.form}.{name}.0", value)
        else:
            whole = acts in ("pair", "leg")
            for leg, places in _by_leg(placed.joints).items():
                for name, value in inside(placed).items():
                    for place in (0,) if whole else places:
                        sim.set_parameter(f"{placed.effect}.{placed.form}.{name}.{place}", value, leg=leg)
    for change in effects.changes:
        value = change.value / si_factor(CHANGES[change.change])
        for leg, places in _by_leg(change.joints).items():
            for place in places:
                _check_change(sim, change.change, leg, place, value)
                sim.set_parameter(f"change.{change.change}.{place}", value, leg=leg)


def inside(placed: PlacedEffect) -> dict[str, float]:
    """Parameters in inside units."""
    return {p.name: placed.parameters[p.name] / si_factor(p.dimension) for p in placed.law.parameters}


def _by_leg(joints: tuple[str, ...]) -> dict[str, list[int]]:
    """Leg -> places of joints."""
    found: dict[str, list[int]] = {}
    for joint in joints:
        leg, axis = joint.split("_")
        found.setdefault(leg, []).append(AXES.index(axis))
    return found


def _check_change(sim: BatchSim, name: str, leg: str, place: int, value: float) -> None:
    if name in ("stiffness", "inertia"):
        rest = float(sim.parameter(f"rest_{name}.{place}")[0, LEGS.index(leg)])
        if rest + value <= 0.0:
            least = -rest * si_factor(CHANGES[name])
            raise ConfigError(f"Change of {name} of {leg}_{AXES[place]} leaves nothing of it; add more than {least:.3g} (SI).")


def _set_feet(sim: BatchSim, placed: PlacedEffect) -> None:
    for leg in placed.legs:
        now = Foot(*(sim.parameter(name)[:, LEGS.index(leg)] for name in _FOOT))
        changed, _ = placed.law.law(now, inside(placed), ())
        for name, value in zip(_FOOT, astuple(changed), strict=True):
            sim.set_parameter(name, value[:, None], leg=leg)


def _set_chassis(sim: BatchSim, placed: PlacedEffect) -> None:
    body = {name: float(sim.body(name)[0]) for name in sim.body_names}
    com, inertia = (tuple(body[f"{name}.{i}"] for i in range(n)) for name, n in (("com", 3), ("inertia", 6)))
    gravity = (-body["pull.0"], -body["pull.1"], -body["gravity"])
    changed, _ = placed.law.law(Chassis(body["mass"], com, inertia, gravity), inside(placed), ())
    x, y, z = changed.gravity
    new = {"mass": changed.mass, "gravity": -z, "pull.0": -x, "pull.1": -y}
    new |= {f"com.{i}": value for i, value in enumerate(changed.com)} | {f"inertia.{i}": value for i, value in enumerate(changed.inertia)}
    for name, value in new.items():
        sim.set_body(name, value)
    if sim.environment == "ground":  # a suspended chassis is held level whatever the ground does
        sim.set_parameter("gravity", np.full((sim.n, 1), -z))
