"""HAMR-simple in MuJoCo: its joints are the hip angles."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import mujoco
import numpy as np
from numba import njit

from hamr_description import mirror, mjcf, units
from hamr_description.names import JOINTS, LEGS, MIRROR, joint_signs
from hamr_description.simple_constants import simple_constants
from hamr_sim_full.mujoco_engine import MujocoEngine, stop_force


def simple_engine(
    parameters: Mapping | None = None, *, environment: str = "ground", friction: float | None = None, gravity: float | None = None
) -> MujocoEngine:
    """HAMR-simple with parameters in the shape of simple.yaml; None takes that file. Else as `hamr_description.mjcf.full`."""
    parameters = simple_constants() if parameters is None else parameters
    xml = mjcf.simple(parameters, environment=environment, friction=friction, gravity=gravity)
    return MujocoEngine(xml, partial(SimpleReadout, parameters=parameters), backend="simple", environment=environment)


def joint_stops(parameters: Mapping) -> np.ndarray:
    """(8, 4) low, high, stiffness, damping of each hip angle's end stops (rad, N mm/rad, N mm ms/rad)."""
    rows = []
    for leg in LEGS:
        constants = parameters[mirror.end(leg)]
        for i, sign in enumerate(joint_signs(leg)):
            low, high = sorted(sign * constants[stop][i] for stop in ("stop_low", "stop_high"))
            rows.append((low, high, constants["stop_stiffness"][i], constants["stop_damping"][i]))
    return np.array(rows)


def tips_per_angle(parameters: Mapping) -> np.ndarray:
    """(8,) tip deflection along +y of the chassis per hip angle, mm/rad: HAMR-full's at rest."""
    ratios = [np.multiply(joint_signs(leg), parameters[mirror.end(leg)]["tip_per_angle"]) for leg in LEGS]
    return np.concatenate([MIRROR[leg][1] * ratio for leg, ratio in zip(LEGS, ratios, strict=True)])


def fill_drive(sample: np.ndarray, torque: np.ndarray, tips: np.ndarray) -> None:
    """Rows of deflection, its rate, torque and force, from the hip rows and drive torques (8,) N mm."""
    np.multiply(sample[:2], units.length_to_si(tips), out=sample[2:4])
    sample[4] = units.torque_to_si(torque)
    sample[5] = torque / tips


class SimpleReadout:
    """Hip angles are joints; tips follow them linearly."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, parameters: Mapping) -> None:
        self._state = (data.qpos[model.nq - model.nv :], data.qvel, data.qacc)
        self._ctrl, self._applied = data.ctrl, data.qfrc_applied
        self._dofs = np.array([model.joint(name).dofadr[0] for name in JOINTS])
        self._gain, self._offset = model.actuator_gainprm[:, 0].copy(), model.actuator_biasprm[:, 0].copy()
        self._stops = joint_stops(parameters)
        self._tips = tips_per_angle(parameters)

    def push_stops(self) -> int:
        """See `Readout`."""
        q, v, _ = self._state
        return _push(q, v, self._dofs, self._stops, self._applied)

    def measure(self, sample: np.ndarray) -> None:
        """See `Readout`."""
        q, v, a = self._state
        sample[0] = q[self._dofs]
        sample[1] = units.rate_to_si(v[self._dofs])
        sample[6] = units.rate_to_si(units.rate_to_si(a[self._dofs]))
        fill_drive(sample, self._gain * self._ctrl + self._offset, self._tips)


@njit(cache=True)
def _push(q, v, dofs, stops, applied):
    hits = 0
    for i, stop in zip(dofs, stops):  # noqa: B905 - numba knows no strict
        applied[i] = stop_force(q[i], v[i], stop[0], stop[1], stop[2], stop[3])
        hits += applied[i] != 0
    return hits
