"""The leg in MuJoCo, from the description's own model: two hinges on a fixed chassis, springs, dampers, gravity, end stops.

Where a law stands between actuator and leg, the actuator gets a hinge of its own (`rotor`) with its share of spring and damper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np

from hamr_description import mjcf
from hamr_description.names import AXES, LEGS
from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants

from .case import JOINTS, LEG

#: Changes of parameters per joint: factors, but for the torque `preload` (N mm) and the zero errors `bias` (rad) and `tip_bias` (mm).
FACTORS = ("drive_gain", "stiffness", "damping", "inertia", "sensor_gain", "tip_gain")
OFFSETS = ("preload", "bias", "tip_bias")
KINDS = (*FACTORS, *OFFSETS)
#: Change of all channels: by how much the sensors' clock is late, ms.
TIME_SHIFT = "time_shift"
_OFF = ("CONSTRAINT", "CONTACT", "SENSOR", "WARMSTART", "CLAMPCTRL")
_DIRECTION = {"swing": (0, 0, 1), "lift": (1, 0, 0)}


def neutral(kind: str) -> float:
    """The value that changes nothing."""
    return 1.0 if kind in FACTORS else 0.0


def change(changes: Mapping[str, float], kind: str, joints: Sequence[str] = JOINTS) -> np.ndarray:
    """(len(joints),) values of a kind, `changes` holding "kind.joint" keys."""
    return np.array([changes.get(f"{kind}.{joint}", neutral(kind)) for joint in joints])


@dataclass(frozen=True, slots=True)
class Machine:
    """A model with its data.

    Attributes:
        model, data: MuJoCo's; at rest.
        dofs: (2,) of the hip angles.
        rotors: (2,) of the actuators' own hinges; those of the hip angles where there is none.
        stops: (2, 4) low, high, stiffness, damping of the end stops.
        ratio: (2,) tip deflection per actuator-side angle, mm/rad.
        gain: (2,) torque per volt, N mm/V.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    dofs: np.ndarray
    rotors: np.ndarray
    stops: np.ndarray
    ratio: np.ndarray
    gain: np.ndarray


#: Share of the actuator's own hinge in a joint's inertia (tip of the bimorph, slider, coupler) and damping.
ROTOR_INERTIA, ROTOR_DAMPING = 0.02, 0.5


def actuator_stiffness() -> np.ndarray:
    """(2,) stiffness of the bimorphs, reflected to the hip angles, N mm/rad."""
    return value("actuator.stiffness") * np.square(simple_constants()["front"]["tip_per_angle"])


def machine(changes: Mapping[str, float], *, step: float, series: tuple[int, ...] = (), coupling: float = 0.0) -> Machine:
    """Build the leg.

    Args:
        changes: of parameters; sensors' are not looked at.
        step: of integration, ms.
        series: joints (indices) whose actuator stands on a hinge of its own.
        coupling: inertia that both joints move together, g mm^2; negative if it moves with their difference.
    """
    model = copy(_model(series, int(np.sign(coupling))))
    model.opt.timestep = step
    dofs = np.array([model.joint(joint).dofadr[0] for joint in JOINTS])
    rotors = np.array([model.joint(_rotor(joint)).dofadr[0] if i in series else dofs[i] for i, joint in enumerate(JOINTS)])
    stiffness, damping, drive = (change(changes, kind) for kind in ("stiffness", "damping", "drive_gain"))
    for i in range(len(JOINTS)):
        own = list({dofs[i], rotors[i]})
        model.jnt_stiffness[own] *= stiffness[i]
        model.dof_damping[own] *= damping[i]
    model.dof_armature[dofs] += (change(changes, "inertia") - 1.0) * np.diag(rest_mass())
    model.dof_armature -= model.dof_damping * step / 2  # Euler damps by the new rate, which acts as so much more inertia
    model.actuator_gainprm[:, 0] *= drive
    model.actuator_biasprm[:, 0] *= drive
    if coupling:
        model.tendon_armature[0] = abs(coupling)
    front = simple_constants()["front"]
    stops = np.array([front[name] for name in ("stop_low", "stop_high", "stop_stiffness", "stop_damping")]).T.copy()
    return Machine(model, mujoco.MjData(model), dofs, rotors, stops, np.array(front["tip_per_angle"]), model.actuator_gainprm[:, 0].copy())


@cache
def rest_mass() -> np.ndarray:
    """(2, 2) mass matrix at rest, g mm^2."""
    model = _model((), 0)
    data, full = mujoco.MjData(model), np.zeros((2, 2))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, full)
    order = [model.joint(joint).dofadr[0] for joint in JOINTS]
    return full[np.ix_(order, order)]


def _rotor(joint: str) -> str:
    return f"{joint}_rotor"


@cache
def _model(series: tuple[int, ...], coupling: int) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(mjcf.simple(simple_constants(), environment="suspended"))
    for key in list(spec.keys):
        spec.delete(key)
    for other in (leg for leg in LEGS if leg != LEG):
        for motor in [actuator for actuator in spec.actuators if actuator.name.startswith(other)]:
            spec.delete(motor)
        spec.delete(spec.body(f"{other}_leg"))
    for part in (*spec.geoms, *spec.sites, *spec.cameras, *spec.lights):
        spec.delete(part)
    for flag in _OFF:
        spec.option.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    for i in series:
        _add_rotor(spec, i)
    if coupling:
        tendon = spec.add_tendon(name="coupling")
        for joint, lever in zip(JOINTS, (1, coupling), strict=True):
            tendon.wrap_joint(joint, lever)
    return spec.compile()


def _add_rotor(spec: mujoco.MjSpec, i: int) -> None:
    joint, hinge = JOINTS[i], spec.joint(JOINTS[i])
    inertia, stiffness, damping = ROTOR_INERTIA * rest_mass()[i, i], actuator_stiffness()[i], ROTOR_DAMPING * hinge.damping[0]
    body = spec.worldbody.add_body(name=_rotor(joint), mass=inertia, inertia=[inertia] * 3, explicitinertial=True)
    direction = _DIRECTION[AXES[i]]
    spring = {"stiffness": [stiffness, 0, 0], "damping": [damping, 0, 0]}
    body.add_joint(name=_rotor(joint), type=mujoco.mjtJoint.mjJNT_HINGE, axis=direction, **spring)
    hinge.stiffness = hinge.stiffness - np.array(spring["stiffness"])
    hinge.damping = hinge.damping - np.array(spring["damping"])
    spec.actuator(f"{joint}_actuator").target = _rotor(joint)
