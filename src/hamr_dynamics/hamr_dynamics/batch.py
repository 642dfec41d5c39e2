"""BatchSim: many robots of one plant, stepped in compiled blocks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import LEGS, drive_sign, joint_signs
from hamr_description.numbers import value
from hamr_description.posture import hang_height, stand_height
from hamr_description.rates import SUBSTEPS

from . import kernels, layout
from .effects.effects_file import EffectsFile
from .effects.effects_file import load as load_effects
from .plant import Plant, flatten, with_effects
from .plant import plant as find_plant
from .set_effects import neutral_leg, set_effects

BLOCK = {"float64": 16, "float32": 32}  # robots whose lanes fill vectors and whose rows still fit the cache
ENVIRONMENTS = ("ground", "suspended")
SIGN = np.array([s for leg in LEGS for s in joint_signs(leg)], float)  # (8,) joint angle -> leg frame
DRIVE_SIGN = np.array([drive_sign(leg) for leg in LEGS for _ in (0, 1)], float)  # (8,) volts -> leg frame


class BatchSim:
    """N independent robots of one plant, in inside units (g, mm, ms, N, V, rad), joints in canonical order.

    Args:
        plant: name of a backend, or a `Plant`.
        n: number of robots.
        environment: "ground" (floating base on flat ground) or "suspended" (chassis held level).
        friction: Coulomb coefficient of all feet, or (n,); default numbers.yaml `contact.friction`.
        gravity: mm/ms^2; default numbers.yaml `robot.gravity`.
        dtype: np.float64 or np.float32.
        block: robots per compiled block; 1 is the one-robot kernel behind the ROS nodes.
        effects: what is added to the model, in all robots: an effects file (`effects.effects_file`) or what was read from one.

    Attributes:
        counts: substeps that each joint's end stops pushed, (n, 8).
    """

    def __init__(
        self, plant: str | Plant, n: int = 1, *, environment: str = "ground", friction=None, gravity: float | None = None,
        dtype=np.float64, block: int | None = None, effects: str | Path | EffectsFile | None = None,
    ) -> None:  # fmt: skip
        if environment not in ENVIRONMENTS:
            raise ConfigError(f"Unknown environment '{environment}': known are {', '.join(ENVIRONMENTS)}.")
        self.effects = load_effects(effects)
        self.plant = find_plant(plant) if isinstance(plant, str) else plant
        if self.effects:
            self.plant = with_effects(self.plant)
        self.n, self.environment, self.dtype = n, environment, np.dtype(dtype)
        self.block = block or (1 if n == 1 else BLOCK[self.dtype.name])
        self._module = kernels.load(self.plant, environment, self.block, self.dtype.name)
        self._blocks = -(-n // self.block)
        self.parameter_names, self.body_names = layout.parameter_rows(self.plant), layout.body_rows(self.plant)
        self._rows, self._seen_rows = layout.state_rows(self.plant), layout.seen_rows(self.plant)
        self._state = self._zeros(self._rows, 4)
        self._target = self._zeros(layout.TARGET, 4)
        self._param = self._zeros(self.parameter_names, 4)
        self._base = self._zeros(layout.BASE, 1)
        self._body = self._zeros(self.body_names, 1)
        self._seen = self._zeros(self._seen_rows, 4)
        self._no_drive = self._zeros(layout.DRIVE, 4)
        network = self.plant.network
        self._weights = np.zeros(1, self.dtype) if network is None else network.weights(self.dtype)
        self._fill_parameters(friction, value("robot.gravity") if gravity is None else gravity)
        set_effects(self, self.effects)
        self.set_gains(value("controller.kp"), value("controller.kd"))
        self.reset()

    def _zeros(self, names, lanes_per_robot: int) -> np.ndarray:
        return np.zeros((self._blocks, len(names) * lanes_per_robot * self.block), self.dtype)

    # --- views: (blocks, rows, legs, robots) -----------------------------------------------------------------------------
    def _legs(self, array: np.ndarray, names, name: str) -> np.ndarray:
        """Rows of a leg-lane array as (n, 8) copy-free view is impossible across blocks: (blocks, 2, 4, robots)."""
        i = names.index(f"{name}.0")
        return array.reshape(self._blocks, len(names), 4, self.block)[:, i : i + 2]

    def _get8(self, array, names, name: str, sign=1.0) -> np.ndarray:
        x = self._legs(array, names, name).transpose(0, 3, 2, 1).reshape(-1, 8)[: self.n]
        return x * np.asarray(sign, self.dtype)

    def _set8(self, array, names, name: str, x, mask=None) -> None:
        view = self._legs(array, names, name).transpose(0, 3, 2, 1)  # blocks, robots, legs, 2
        full = view.reshape(-1, 8)
        chosen = slice(0, self.n) if mask is None else np.flatnonzero(mask)
        full[chosen] = x
        view[...] = full.reshape(view.shape)

    def _get(self, array, names, name: str, size: int) -> np.ndarray:
        i = names.index(f"{name}.0" if size > 1 else name)
        return array.reshape(self._blocks, len(names), self.block)[:, i : i + size].transpose(0, 2, 1).reshape(-1, size)[: self.n]

    def _set(self, array, names, name: str, size: int, x, mask=None) -> None:
        i = names.index(f"{name}.0" if size > 1 else name)
        view = array.reshape(self._blocks, len(names), self.block)[:, i : i + size].transpose(0, 2, 1)
        full = view.reshape(-1, size)
        chosen = slice(0, self.n) if mask is None else np.flatnonzero(mask)
        full[chosen] = x
        view[...] = full.reshape(view.shape)

    # --- parameters ------------------------------------------------------------------------------------------------------
    def _fill_parameters(self, friction, gravity: float) -> None:
        view = self._param.reshape(self._blocks, len(self.parameter_names), 4, self.block)
        flat = [flatten(self.plant.parameters(leg)) for leg in LEGS]
        if self.plant.effects:
            flat = [own | neutral_leg(self.plant, leg, gravity) for own, leg in zip(flat, LEGS, strict=True)]
        ground = {
            "friction": value("contact.friction"), "contact_stiffness": value("contact.stiffness"),
            "contact_damping": value("contact.damping"), "slip_speed": value("contact.slip_speed"), "gravity": gravity,
        }  # fmt: skip
        for row, name in enumerate(self.parameter_names):
            for i in range(4):
                view[:, row, i] = ground[name] if name in ground else flat[i][name]
        if friction is not None:
            self.set_parameter("friction", np.broadcast_to(np.asarray(friction, float), (self.n,))[:, None])
        body = self._body.reshape(self._blocks, len(self.body_names), self.block)
        chassis = [self.plant.chassis["mass"], *self.plant.chassis["com"], *self.plant.chassis["inertia"], gravity]
        body[:, : len(chassis)] = np.array(chassis)[None, :, None]  # what follows is zero without effects

    def parameter(self, name: str) -> np.ndarray:
        """A lane parameter as (n, 4), legs in order; names in `parameter_names`."""
        row = self._parameter_row(name)
        return self._param.reshape(self._blocks, -1, 4, self.block)[:, row].transpose(0, 2, 1).reshape(-1, 4)[: self.n].copy()

    def set_parameter(self, name: str, x, *, leg: str = "") -> None:
        """Sets a lane parameter; x broadcasts to (n, 4), or of one leg to (n, 1)."""
        row = self._parameter_row(name)
        view = self._param.reshape(self._blocks, -1, 4, self.block)[:, row].transpose(0, 2, 1)
        full = view.reshape(-1, 4)
        legs = slice(LEGS.index(leg), LEGS.index(leg) + 1) if leg else slice(None)
        full[: self.n, legs] = x
        full[self.n :] = full[0]
        view[...] = full.reshape(view.shape)

    def body(self, name: str) -> np.ndarray:
        """(n,) a parameter of the chassis; names in `body_names`."""
        return self._get(self._body, self.body_names, name, 1)[:, 0].copy()

    def set_body(self, name: str, x) -> None:
        """Sets a parameter of the chassis; x broadcasts to (n,)."""
        self._set(self._body, self.body_names, name, 1, np.broadcast_to(x, (self.n,))[:, None])

    def _parameter_row(self, name: str) -> int:
        if name not in self.parameter_names:
            raise ConfigError(f"'{name}' is no lane parameter of '{self.plant.name}': known are {', '.join(self.parameter_names)}.")
        return self.parameter_names.index(name)

    def set_gains(self, kp, kd) -> None:
        """Gains of the leg law: V/rad and V ms/rad, scalars or (8,) or (n, 8)."""
        self._set8(self._target, layout.TARGET, "kp", np.broadcast_to(kp, (self.n, 8)))
        self._set8(self._target, layout.TARGET, "kd", np.broadcast_to(kd, (self.n, 8)))

    # --- state -----------------------------------------------------------------------------------------------------------
    def reset(self, mask=None) -> None:
        """Stand at rest, feet just touching the ground (or hang at rest); all robots, or those of an (n,) mask."""
        height = stand_height() if self.environment == "ground" else hang_height()
        self.set_state(
            q=0.0, qd=0.0, position=(0.0, 0.0, height), quaternion=(1.0, 0.0, 0.0, 0.0), velocity=0.0, angular_velocity=0.0, mask=mask
        )

    def set_state(self, *, q=None, qd=None, position=None, quaternion=None, velocity=None, angular_velocity=None, mask=None) -> None:
        """Sets parts of the state (shapes and units as the attributes); forgets the last accelerations and what effects remember."""
        for name, x in (("q", q), ("v", qd)):
            if x is not None:
                self._set8(self._state, self._rows, name, np.asarray(x) * SIGN, mask)
        bases = {"position": position, "quaternion": quaternion, "velocity": velocity, "omega": angular_velocity}
        for name, x in bases.items():
            if x is not None:
                self._set(self._base, layout.BASE, name, 4 if name == "quaternion" else 3, x, mask)
        self._set8(self._state, self._rows, "a", 0.0, mask)
        self._forget(mask)
        self._set(self._base, layout.BASE, "alpha", 3, 0.0, mask)

    def _forget(self, mask) -> None:
        """Memories of effects, of the robots of a mask, as at rest."""
        chosen = np.ones(self._blocks * self.block, bool)
        if mask is not None:
            chosen[: self.n] = mask
        memories = self._state.reshape(self._blocks, len(self._rows), 4, self.block)[:, len(layout.STATE) :]
        np.moveaxis(memories, 3, 1)[chosen.reshape(self._blocks, self.block)] = 0.0

    @property
    def q(self) -> np.ndarray:
        """(n, 8) hip angles, rad."""
        return self._get8(self._state, self._rows, "q", SIGN)

    @property
    def qd(self) -> np.ndarray:
        """(n, 8) hip rates, rad/ms."""
        return self._get8(self._state, self._rows, "v", SIGN)

    @property
    def qdd(self) -> np.ndarray:
        """(n, 8) hip accelerations over the last substep, rad/ms^2."""
        return self._get8(self._state, self._rows, "a", SIGN)

    def measured(self) -> tuple[np.ndarray, np.ndarray]:
        """Hip angles (n, 8) rad and rates (n, 8) rad/ms as the sensors have them; without effects the true ones."""
        if not self.plant.effects:
            return self.q, self.qd
        self._module.look(self._state, self._no_drive, self._param, self._weights, self._seen)
        return tuple(self._get8(self._seen, self._seen_rows, f"measured.{name}", SIGN) for name in "qv")

    @property
    def counts(self) -> np.ndarray:
        """(n, 8) substeps in which an end stop pushed, since construction."""
        return self._get8(self._state, self._rows, "stops")

    @property
    def position(self) -> np.ndarray:
        """(n, 3) origin of the chassis frame in the world, mm."""
        return self._get(self._base, layout.BASE, "position", 3)

    @property
    def quaternion(self) -> np.ndarray:
        """(n, 4) chassis orientation, wxyz."""
        return self._get(self._base, layout.BASE, "quaternion", 4)

    @property
    def velocity(self) -> np.ndarray:
        """(n, 3) velocity of the chassis frame's origin, world axes, mm/ms."""
        return self._get(self._base, layout.BASE, "velocity", 3)

    @property
    def angular_velocity(self) -> np.ndarray:
        """(n, 3) angular velocity of the chassis in its own axes, rad/ms."""
        return self._get(self._base, layout.BASE, "omega", 3)

    @property
    def finite(self) -> np.ndarray:
        """(n,) whether a robot's state is finite."""
        legs = np.isfinite(self._get8(self._state, self._rows, "q") + self._get8(self._state, self._rows, "v")).all(1)
        return legs & np.isfinite(self.position).all(1) & np.isfinite(self.quaternion).all(1)

    # --- stepping --------------------------------------------------------------------------------------------------------
    def step_targets(self, targets, *, steps: int = SUBSTEPS, record: bool = False) -> dict[str, np.ndarray] | None:
        """Runs the leg law at 20 kHz towards targets (n, 8) rad for `steps` substeps.

        With `record`, returns the state before each substep and the voltage held over it: q, qd (n, steps, 8) rad, rad/ms, volts V.
        """
        self._set8(self._target, layout.TARGET, "target", np.asarray(targets) * SIGN)
        return self._advance(steps, True, np.zeros((self._blocks, 1, 2 * 4 * self.block), self.dtype), record)

    def step_voltages(self, volts, *, record: bool = False) -> dict[str, np.ndarray] | None:
        """Holds each of volts (n, k, 8) V for one substep; `record` as in `step_targets`."""
        volts = np.asarray(volts, float)
        if volts.shape[0] != self.n or volts.shape[2:] != (8,):
            raise ConfigError(f"Voltages must have shape ({self.n}, k, 8), not {volts.shape}: one row per robot and substep.")
        steps = volts.shape[1]
        drive = np.zeros((self._blocks * self.block, steps, 4, 2), self.dtype)
        drive[: self.n] = ((volts - value("actuator.neutral_voltage")) * DRIVE_SIGN).reshape(self.n, steps, 4, 2)
        lanes = drive.reshape(self._blocks, self.block, steps, 4, 2).transpose(0, 2, 4, 3, 1)
        return self._advance(steps, False, np.ascontiguousarray(lanes).reshape(self._blocks, steps, -1), record)

    def _advance(self, steps: int, servoed: bool, drive: np.ndarray, record: bool) -> dict[str, np.ndarray] | None:
        kept = np.empty((self._blocks, steps if record else 0, 6 * 4 * self.block), self.dtype)
        self._module.advance(
            steps, servoed, self._state, drive, self._target, self._param, self._base, self._body, self._weights, kept
        )
        if not record:
            return None
        rows = kept.reshape(self._blocks, steps, 3, 2, 4, self.block).transpose(2, 0, 5, 1, 4, 3).reshape(3, -1, steps, 8)[:, : self.n]
        return {"q": rows[0] * SIGN, "qd": rows[1] * SIGN, "volts": rows[2] * DRIVE_SIGN + value("actuator.neutral_voltage")}

    def observe(self, volts) -> Mapping[str, np.ndarray]:
        """Tip mm, tip_rate mm/ms, tip_force N (along +y of the chassis) and torque N mm of the drive, (n, 8) each.

        Forces are those at volts (n, 8) V, or with effects, which remember, those of the last step.
        """
        drive = self._no_drive.copy()
        self._set8(drive, layout.DRIVE, "drive", (np.asarray(volts, float) - value("actuator.neutral_voltage")) * DRIVE_SIGN)
        self._module.look(self._state, drive, self._param, self._weights, self._seen)
        along_y = np.array([joint_signs(leg)[1] for leg in LEGS for _ in (0, 1)], float)
        signs = {"tip": along_y, "tip_rate": along_y, "tip_force": along_y, "torque": SIGN}
        return {name: self._get8(self._seen, self._seen_rows, name, sign) for name, sign in signs.items()}
