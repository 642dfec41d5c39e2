"""The whole robot on the ground in MuJoCo, from the description's own model, with a scene's numbers in it; and runs of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cache

import mujoco
import numpy as np

from hamr_description import mirror, mjcf
from hamr_description.errors import ModelError
from hamr_description.mjcf_looks import FLOOR
from hamr_description.names import BASE_FRAME, JOINTS, LEGS, joint_signs
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ, SERVO_MS
from hamr_description.simple_constants import simple_constants

from ..laws.law import LAWS, SIZE, address
from ..loop import step_address
from ..machine import change
from .laws import Scene
from .loop import walk

STEP = 0.025  # ms
SAMPLE_HZ = 4000
EVERY = SERVO_HZ // SAMPLE_HZ
#: Share of MuJoCo's constraint in a contact's normal direction, and how much harder it is sideways: a spring and damper, and friction.
SHARE, SIDEWAYS = 1e-3, 1e5
PAYLOAD_SIZE = 1.5  # mm, radius of gyration


@dataclass(frozen=True, slots=True)
class Walk:
    """Coordinates (n, 15) at 4 kHz, free joint first, hip angles in the order of names.JOINTS; states at marks, in MuJoCo's own order."""

    qpos: np.ndarray
    mark_qpos: np.ndarray
    mark_qvel: np.ndarray


class Walker:
    """The robot, standing, in a scene with parameter changes ("kind.joint", as machine.KINDS)."""

    def __init__(self, scene: Scene, changes: Mapping[str, float], *, step: float = STEP) -> None:
        self.scene, self.changes, self.step = scene, changes, step
        self.model = model = copy(_model(self.scene.payload, self.scene.seat))
        model.opt.timestep, model.opt.gravity[:] = self.step, self.scene.gravity
        _set_contact(model, self.scene)
        self._dofs = np.array([model.joint(joint).dofadr[0] for joint in JOINTS])
        stiffness, damping, inertia, drive = (self._change(kind) for kind in ("stiffness", "damping", "inertia", "drive_gain"))
        self._mass = model.dof_M0[self._dofs].copy()
        model.jnt_stiffness[[model.joint(joint).id for joint in JOINTS]] *= stiffness
        model.dof_damping[self._dofs] *= damping
        model.dof_armature[self._dofs] += (inertia - 1.0) * self._mass
        model.actuator_gainprm[:, 0] *= drive
        model.actuator_biasprm[:, 0] *= drive
        self._stops = _stops()
        self.data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, self.data, model.key("stand").id)
        mujoco.mj_forward(model, self.data)
        self._home = self.data.body(BASE_FRAME).xpos + np.array(self.scene.hook)

    def _change(self, kind: str) -> np.ndarray:
        return change(self.changes, kind, JOINTS)

    def set(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        """Put it into a state."""
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        mujoco.mj_forward(self.model, self.data)

    def run(self, volts: np.ndarray, marks: Sequence[int] = ()) -> Walk:
        """From the state it is in, under voltages (n, 8) V at 20 kHz; ModelError if it diverges."""
        model, data, scene, base = self.model, self.data, self.scene, self.data.body(BASE_FRAME)
        addresses, legs, joints, first_p, first_s, p, states = [], [], [], [], [], [], 0
        for effect in sorted(scene.legs, key=lambda effect: list(LAWS).index(effect.law)):
            law = LAWS[effect.law]
            for j, joint in enumerate(JOINTS):
                if joint in effect.joints:
                    addresses.append(address(effect.law))
                    legs.append(j // 2)
                    joints.append(j % 2)
                    first_p.append(len(p))
                    first_s.append(states)
                    states += law.count(effect.parameters, self.step)
            p.extend(law.numbers(effect.parameters, self.step))
        rows = -(-len(volts) // EVERY)
        found = Walk(np.empty((rows, model.nq)), np.empty((len(marks), model.nq)), np.empty((len(marks), model.nv)))
        feet = np.array([model.geom(f"{leg}_foot").id for leg in LEGS])
        fine = walk(
            step_address(), model._address, data._address, data.qpos, data.qvel, data.ctrl, data.qfrc_applied, self._dofs, self._stops,
            self._mass, model.actuator_gainprm[:, 0].copy(), self._change("preload"), value("actuator.neutral_voltage"),
            np.ascontiguousarray(volts), EVERY, round(SERVO_MS / self.step), self.step,
            *(np.array(numbers, np.int64) for numbers in (addresses, legs, joints, first_p, first_s)),
            np.array([*p, 0.0]), np.zeros(states + 1), np.zeros((len(LEGS), SIZE)),
            model.pair_friction, data.geom_xpos, feet, scene.friction, scene.fall, scene.slip,
            data.xfrc_applied[base.id], base.xpos, base.xmat, base.xipos,
            np.array(scene.pull), scene.coil, scene.reach, np.array(scene.hook), self._home,
            np.array(marks, np.int64), found.qpos, found.mark_qpos, found.mark_qvel,
        )  # fmt: skip
        if not fine or not np.isfinite(found.qpos).all():
            raise ModelError("the hidden robot diverges; draw another seed.")
        order = np.r_[:7, [model.joint(joint).qposadr[0] for joint in JOINTS]]
        return replace(found, qpos=found.qpos[:, order])


@cache
def _model(payload: float, seat: tuple[float, float, float]) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(mjcf.simple(simple_constants(), environment="ground"))
    keep = {FLOOR, *(f"{leg}_foot" for leg in LEGS)}
    for part in (*(geom for geom in spec.geoms if geom.name not in keep), *spec.sites, *spec.cameras, *spec.lights):
        spec.delete(part)
    if payload:
        size = payload * PAYLOAD_SIZE**2
        spec.body(BASE_FRAME).add_body(name="payload", pos=seat, mass=payload, inertia=[size] * 3, explicitinertial=True)
    return spec.compile()


def _set_contact(model: mujoco.MjModel, scene: Scene) -> None:
    """Feet on a spring and damper, with Coulomb friction.

    MuJoCo's constraint force is (stiffness r + damping v) / R for an impedance so small that the regulariser R, an inverse mass, is
    all that counts; tangentially R is SIDEWAYS times less, and the damping such that a foot is stopped within a step.
    """
    model.opt.impratio = SIDEWAYS
    for pair in range(model.npair):
        bodies = model.geom_bodyid[[model.pair_geom1[pair], model.pair_geom2[pair]]]
        soft = (1.0 - SHARE) * model.body_invweight0[bodies, 0].sum()
        model.pair_solimp[pair, :2] = SHARE
        model.pair_solref[pair] = -soft * scene.stiffness, -soft * scene.damping
        model.pair_solreffriction[pair] = 0.0, -SHARE / model.opt.timestep
        model.pair_friction[pair, :2] = scene.friction


def _stops() -> np.ndarray:
    """(8, 4) low, high, stiffness, damping of the hips' end stops."""
    rows = []
    for leg in LEGS:
        numbers = simple_constants()[mirror.end(leg)]
        for i, sign in enumerate(joint_signs(leg)):
            low, high = sorted(sign * numbers[stop][i] for stop in ("stop_low", "stop_high"))
            rows.append((low, high, numbers["stop_stiffness"][i], numbers["stop_damping"][i]))
    return np.array(rows)
