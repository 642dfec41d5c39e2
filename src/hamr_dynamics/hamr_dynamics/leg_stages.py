"""The traced stages of a leg: `step` fed with the rows that `layout` names. The step of a leg on a fixed chassis is one of them."""

from __future__ import annotations

from collections.abc import Callable

from . import bank_stages, scalar
from .emit import Part, Stage
from .layout import DRIVE, STATE, TARGET, parameter_rows, read_parameters, read_state, seen_rows, state_rows, write_state
from .plant import Plant
from .step import ahead, step_suspended


def _arrays(plant: Plant) -> dict[str, tuple[str, ...]]:
    return {"state": state_rows(plant), "param": parameter_rows(plant)}


def _driven(plant: Plant) -> dict[str, tuple[str, ...]]:
    return {"state": state_rows(plant), "drive": DRIVE, "param": parameter_rows(plant)}


def sense(plant: Plant, h: float) -> list[Part]:
    """What the sensors say, which the leg law sees; nothing of a plant without effects, whose sensors are true."""
    return bank_stages.sense(_arrays(plant), h) if plant.effects else []


def command(plant: Plant, h: float) -> list[Part]:
    """The drive that acts, of the commanded one; nothing of a plant without effects."""
    return bank_stages.command(_arrays(plant), DRIVE, h) if plant.effects else []


def forces(plant: Plant, h: float) -> list[Part]:
    """What effects add to a leg's equations; nothing of a plant without effects."""

    def middle(stage: Stage) -> tuple[tuple, tuple]:
        state = read_state(stage)
        return ahead(state, h)[0], state.v

    return bank_stages.forces(plant, _arrays(plant), DRIVE, middle, lambda stage: read_parameters(stage, plant), h) if plant.effects else []


def leg_arrays(plant: Plant) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Inputs of a stage that evaluates `leg_function`, and its outputs besides its own."""
    more, moved = ({"equations": bank_stages.EQUATIONS}, {"moved": bank_stages.MOVED}) if plant.effects else ({}, {})
    return _driven(plant) | more, moved


def leg_function(plant: Plant, stage: Stage, h: float) -> Callable:
    """The plant's leg function, with the equations that effects have changed if its kernels carry them."""
    return bank_stages.leg(plant, stage, h) if plant.effects else plant.leg


def suspended(plant: Plant, h: float) -> Stage:
    """A whole step of a leg on a fixed chassis."""
    inputs, moved = leg_arrays(plant)
    stage = Stage("suspended", inputs, {"new_state": STATE} | moved)
    state, leg = step_suspended(
        leg_function(plant, stage, h), read_state(stage), stage.reads("drive", "drive", 2), read_parameters(stage, plant),
        stage.read("param", "gravity"), h,
    )  # fmt: skip
    write_state(stage, state, leg.stop)
    return stage


def suspended_leg(plant: Plant, h: float) -> Stage:
    """The same step without the stop counts: smooth rows only, for derivatives."""
    stage = Stage("suspended", {"state": STATE[:6], "drive": DRIVE, "param": parameter_rows(plant)}, {"new_state": STATE[:6]})
    state, _ = step_suspended(
        plant.leg, read_state(stage), stage.reads("drive", "drive", 2), read_parameters(stage, plant), stage.read("param", "gravity"), h
    )
    for name in "qva":
        stage.write("new_state", name, getattr(state, name))
    return stage


def servo(limit: float) -> Stage:
    """The leg law in the leg frame: drive = clip(kp (target - q) - kd v)."""
    stage = Stage("servo", {"state": STATE, "target": TARGET}, {"drive": DRIVE})
    q, v = stage.reads("state", "q", 2), stage.reads("state", "v", 2)
    target, kp, kd = (stage.reads("target", name, 2) for name in ("target", "kp", "kd"))
    law = (scalar.clip(kp[i] * (target[i] - q[i]) - kd[i] * v[i], -limit, limit) for i in (0, 1))
    stage.write("drive", "drive", tuple(law))
    return stage


def observe(plant: Plant, h: float) -> Stage:
    """What only a simulator knows of a leg: actuator tips, their rates and forces, and the drive's hip torque."""
    stage = Stage("observe", _driven(plant), {"seen": seen_rows(plant)})
    state = read_state(stage)
    leg = plant.leg(state.q, state.v, stage.reads("drive", "drive", 2), read_parameters(stage, plant))
    if plant.effects:
        leg = bank_stages.seen(stage, leg, h)
    tips = tuple(t.value for t in leg.tips), tuple(t.rate(state.v) for t in leg.tips)
    tip, tip_rate = bank_stages.tips(stage, leg, state.v) if plant.effects else tips
    stage.write("seen", "tip", tip)
    stage.write("seen", "tip_rate", tip_rate)
    stage.write("seen", "tip_force", tuple(leg.tip_force))
    stage.write("seen", "torque", tuple(leg.torque))
    return stage
