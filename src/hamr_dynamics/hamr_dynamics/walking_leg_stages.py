"""The traced stages of a leg that walks: it is eliminated, given what the ground gives, and follows the chassis."""

from __future__ import annotations

from . import bank_stages, vec
from .contact import Contact
from .emit import Stage
from .layout import GROUND, GROUNDED, INCREMENT, NEAR, REACH, STATE, parameter_rows, read_parameters, read_state, write_state
from .leg_stages import leg_arrays, leg_function
from .plant import Plant
from .step import Reach, apply_ground, finish, ground_force, leg_increment, reach_leg


def reach(plant: Plant, h: float) -> Stage:
    """Eliminates a leg."""
    near = (*NEAR, *bank_stages.NEAR) if plant.effects else NEAR
    inputs, moved = leg_arrays(plant)
    stage = Stage("reach", inputs | {"near": near}, {"reach": REACH} | moved)
    base = {name: stage.reads("near", name, 3) for name in ("omega", "omega_mid", "velocity", "normal")}
    base |= {"height": stage.read("near", "height"), "gravity": stage.read("param", "gravity")}
    ground = {name.removeprefix("contact_"): stage.read("param", name) for name in GROUND}
    more = {"pull": stage.reads("near", "pull", 3)} if plant.effects else {}
    r = reach_leg(
        leg_function(plant, stage, h), read_state(stage), stage.reads("drive", "drive", 2), read_parameters(stage, plant),
        base, ground, h, **more,
    )  # fmt: skip
    stage.write("reach", "soft_matrix", r.soft_matrix)
    stage.write("reach", "soft_rhs", r.soft_rhs)
    stage.write("reach", "free_matrix", r.free_matrix)
    stage.write("reach", "free_rhs", r.free_rhs)
    for name in ("soft_gain", "free_gain"):
        stage.write("reach", name, tuple(x for row in getattr(r, name) for x in row))
    stage.write("reach", "soft_own", r.soft_own)
    stage.write("reach", "free_own", r.free_own)
    stage.write("reach", "solve", r.solve)
    stage.write("reach", "jacobian", tuple(x for column in r.jacobian for x in column))
    stage.write("reach", "point", r.point)
    stage.write("reach", "contact", (r.contact.push, r.contact.grip, r.contact.slip, *r.contact.velocity))
    stage.write("reach", "stop", r.stop)
    return stage


def grounded(plant: Plant, h: float) -> Stage:
    """What the ground really gives each foot."""
    inputs = {"param": parameter_rows(plant), "near": NEAR, "reach": REACH, "soft": INCREMENT}
    stage = Stage("grounded", inputs, {"grounded": GROUNDED})
    increment = stage.reads("soft", "increment", 6)
    r = _read_reach(stage)
    force = ground_force(r, increment, leg_increment(r.soft_own, r.soft_gain, increment), stage.read("param", "friction"))
    rhs, own = apply_ground(r, force, h)
    stage.write("grounded", "rhs", rhs)
    stage.write("grounded", "own", own)
    stage.write("grounded", "force", force)
    return stage


def finish_legs(h: float) -> Stage:
    """New leg states from the base's final increment."""
    stage = Stage("finish_legs", {"state": STATE, "reach": REACH, "grounded": GROUNDED, "free": INCREMENT}, {"new_state": STATE})
    r = Reach((), (), (), (), (), (), (stage.reads("reach", "free_gain", 12)[:6], stage.reads("reach", "free_gain", 12)[6:]),
              stage.reads("reach", "free_own", 2), (), (), (), None, stage.reads("reach", "stop", 2))  # fmt: skip
    own = vec.add(r.free_own, stage.reads("grounded", "own", 2))
    new = finish(read_state(stage), leg_increment(own, r.free_gain, stage.reads("free", "increment", 6)), h)
    write_state(stage, new, r.stop)
    return stage


def _read_reach(stage: Stage) -> Reach:
    def gain(name):
        flat = stage.reads("reach", name, 12)
        return flat[:6], flat[6:]

    jacobian = stage.reads("reach", "jacobian", 6)
    push, grip, slip, *velocity = stage.reads("reach", "contact", 6)
    contact = Contact(stage.reads("near", "normal", 3), push, grip, slip, tuple(velocity))
    return Reach(
        (), (), gain("soft_gain"), stage.reads("reach", "soft_own", 2), (), (), gain("free_gain"),
        stage.reads("reach", "free_own", 2), stage.reads("reach", "solve", 3), (jacobian[:3], jacobian[3:]),
        stage.reads("reach", "point", 3), contact, stage.reads("reach", "stop", 2),
    )  # fmt: skip
