"""Two short walks of HAMR-simple, with an effect and without: it stands, then trots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from hamr_bags.signals import Trot, samples
from hamr_description.names import JOINTS
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ, SUBSTEPS
from hamr_description.units import quaternion_to_ros
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.effects.effects_file import EffectsFile, PlacedEffect

from .figure import Panel, pair

STAND_S, TROT_S = 0.12, 0.8
GAIT = {"frequency_hz": 15.0, "amplitude": 60.0}
DROP_MM, DROP_S = 2.0, 0.08


@dataclass(frozen=True, slots=True)
class Seen:
    """Without and with: time (n,) s; position (2, n, 3) mm; pitch (2, n) rad."""

    time: np.ndarray
    position: np.ndarray
    pitch: np.ndarray


@dataclass(frozen=True)
class Walks:
    """The robot as it is and with an effect, under the same voltages."""

    placed: PlacedEffect

    @cached_property
    def trot(self) -> Seen:
        volts = Trot(seconds=TROT_S, **GAIT).deviation()
        return self._seen(np.concatenate([np.zeros((samples(STAND_S), volts.shape[1])), volts]), SUBSTEPS)

    @cached_property
    def drop(self) -> Seen:
        return self._seen(np.zeros((samples(DROP_S), len(JOINTS))), SUBSTEPS // 8, above=DROP_MM)

    def _seen(self, volts: np.ndarray, every: int, above: float = 0.0) -> Seen:
        runs = []
        for effects in (None, EffectsFile((self.placed,))):
            sim = BatchSim("simple", effects=effects)
            sim.set_state(position=(0.0, 0.0, sim.position[0, 2] + above))
            runs.append([self._pose(sim)])
            for part in volts.reshape(-1, every, volts.shape[1]):
                sim.step_voltages(part[None] + value("actuator.neutral_voltage"))
                runs[-1].append(self._pose(sim))
        pose = np.array(runs)
        return Seen(np.arange(pose.shape[1]) * every / SERVO_HZ, pose[..., :3], pose[..., 3])

    @staticmethod
    def _pose(sim: BatchSim) -> np.ndarray:
        """(4,) position mm, pitch rad."""
        pitch = Rotation.from_quat(quaternion_to_ros(sim.quaternion[0])).as_euler("ZYX")[1]
        return np.array([*sim.position[0], pitch])


def path(run: Walks) -> Panel:
    x, y = run.trot.position[..., 0], run.trot.position[..., 1]
    return Panel("path from above", "x, mm", "y, mm", pair(x, y), "where the trot takes the robot, from above; it begins at 0, 0")


def way(run: Walks) -> Panel:
    return Panel(
        "along x", "s", "x, mm", pair(run.trot.time, run.trot.position[..., 0]), "how far it comes: this open-loop trot walks backwards"
    )


def height(run: Walks) -> Panel:
    return Panel(
        "height of the chassis", "s", "z, mm", pair(run.trot.time, run.trot.position[..., 2]), f"it stands for {STAND_S:g} s, then trots"
    )


def pitch(run: Walks) -> Panel:
    return Panel("pitch", "s", "rad", pair(run.trot.time, run.trot.pitch), "positive where the nose is lower")


def drop(run: Walks) -> Panel:
    return Panel(
        f"dropped from {DROP_MM:g} mm", "ms", "height of the chassis, mm", pair(1e3 * run.drop.time, run.drop.position[..., 2]),
        "how deep it lands and how it bounces, without any drive",
    )  # fmt: skip


PICTURES: dict[str, Callable[[Walks], Panel]] = {f.__name__: f for f in (path, way, height, pitch, drop)}
