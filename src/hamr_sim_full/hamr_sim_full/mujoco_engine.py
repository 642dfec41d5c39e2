"""One robot in MuJoCo behind hamr_dynamics.engine.Engine: the second, independently written implementation.

The model text comes from hamr_description.mjcf; a `Readout` knows how hip angles, tips and end stops lie in its coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import mujoco
import numpy as np
from numba import njit

from hamr_description import units
from hamr_description.names import BASE_FRAME

from .mujoco_contact import set_contact

BAD_NUMBERS = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


class Readout(Protocol):
    """The model-specific part; bound to one model and its data."""

    def push_stops(self) -> int:
        """Write the end stops' forces into qfrc_applied; how many stops push."""

    def measure(self, sample: np.ndarray) -> None:
        """Fill (7, 8) with the rows of hamr_dynamics.engine.ROWS, SI.

        Torque and force are those at the present state under the last voltages; acceleration is that of the last substep.
        """


class MujocoEngine:
    """One robot (see `hamr_dynamics.engine.Engine`).

    Args:
        xml: a model of hamr_description.mjcf.
        readout: makes the readout from (model, data).
        backend: name of the model; environment: the one that xml was built for.
    """

    engine = "mujoco"

    def __init__(self, xml: str, readout: Callable[[mujoco.MjModel, mujoco.MjData], Readout], *, backend: str, environment: str) -> None:
        self.backend = backend
        self.environment = environment
        self.model = mujoco.MjModel.from_xml_string(xml)
        set_contact(self.model)
        self.data = mujoco.MjData(self.model)
        self._readout = readout(self.model, self.data)
        self._ctrl = self.data.ctrl
        self._base = self.data.body(BASE_FRAME)
        self._stand = self.model.key("stand").id
        self._twist = np.empty(6)
        self._stops_hit = 0
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Keyframe `stand`, at rest, drives neutral. Nothing here is random; the seed is taken for the protocol's sake."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, self._stand)
        mujoco.mj_forward(self.model, self.data)
        self._stops_hit = 0

    def substep(self, volts: np.ndarray) -> None:
        """One step of 50 us under drive voltages (8,) V."""
        self._ctrl[:] = volts
        self._stops_hit += self._readout.push_stops()
        mujoco.mj_step(self.model, self.data)

    def measure(self, sample: np.ndarray) -> None:
        """Fill sample (7, 8), see `Readout.measure`."""
        self._readout.measure(sample)

    def base(self, out: np.ndarray) -> None:
        """Fill (13,): position m, quaternion xyzw, velocity m/s and angular velocity rad/s in base_link."""
        mujoco.mj_kinematics(self.model, self.data)  # mj_step leaves poses one step behind the coordinates
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, self._base.id, self._twist, 1)
        out[:3] = units.length_to_si(self._base.xpos)
        out[3:7] = units.quaternion_to_ros(self._base.xquat)
        out[7:10] = self._twist[3:]  # mm/ms equal m/s
        out[10:13] = units.rate_to_si(self._twist[:3])

    def counters(self) -> dict[str, float]:
        """stops_hit since reset (joint-substeps); constraint_residual, the largest loop closure error now, mm; finite (1 or 0)."""
        data = self.data
        # MuJoCo resets a state that is not finite and says so by a warning only
        warned = any(data.warning[int(kind)].number for kind in BAD_NUMBERS)
        return {
            "stops_hit": float(self._stops_hit),
            "constraint_residual": float(np.abs(data.efc_pos[: data.ne]).max(initial=0.0)),
            "finite": float(not warned and np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()),
        }


@njit(cache=True)
def stop_force(x: float, rate: float, low: float, high: float, stiffness: float, damping: float) -> float:
    """Force of the end stops at low and high: a spring and damper while x is beyond one of them; never pulls."""
    if x > high:
        return -max(stiffness * (x - high) + damping * rate, 0.0)
    if x < low:
        return max(stiffness * (low - x) - damping * rate, 0.0)
    return 0.0
