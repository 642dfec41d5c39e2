"""The whole robot as lanes: states, recorded voltages and parameter sets in, angles and poses out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import kernels
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.machine import leg_machine
from hamr_dynamics.plant import Plant, plant, with_effects
from hamr_dynamics.set_effects import set_effects

from .segments import POSITION, QD, QUATERNION, SPIN, STATE, VELOCITY, Q
from .setting import Setting

LANES = 1024  # simulated at once
BLOCK = 16


@dataclass(frozen=True)
class Numerics:
    """How finely to simulate: steps in each servo period, and the slip speed below which friction is viscous, as a share of the model's."""

    fine: int = 1
    slip: float = 1.0


@dataclass(frozen=True)
class Runs:
    """What lanes did at each sample after their starts: angles (n, k, 8) rad, position (n, k, 3) mm, quaternion (n, k, 4); and the states
    (n, 29) that they end in."""

    angles: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    ends: np.ndarray


@dataclass(frozen=True)
class Drives:
    """Voltages of segments at every step of each sample (s, k, steps, 8) V with two derivatives, and for a while before with one.

    Attributes:
        volts V, slopes V/ms, bends V/ms^2. lead_volts, lead_slopes: (s, j, steps, 8).
        lead_angles, lead_rates: (s, j, 8), smoothed, rad and rad/ms.
    """

    volts: np.ndarray
    slopes: np.ndarray
    bends: np.ndarray
    lead_volts: np.ndarray
    lead_slopes: np.ndarray
    lead_angles: np.ndarray
    lead_rates: np.ndarray

    def some(self, index: np.ndarray) -> Drives:
        """Of a choice of segments."""
        return Drives(*(getattr(self, f.name)[index] for f in fields(self)))


class _Lanes(BatchSim):
    """Robots whose effects may keep what they remember while their motion is set."""

    keep = False

    def _forget(self, mask) -> None:
        if not self.keep:
            super()._forget(mask)


class _Kernels:
    """Simulators of a plant, of several numbers of lanes."""

    def __init__(self, plant: Plant, numerics: Numerics) -> None:
        self._plant, self._numerics = plant, numerics
        self._sims: dict[int, _Lanes] = {}
        one = self.of(BLOCK)
        self._neutral = one._param.copy(), one._body.copy()

    def of(self, count: int) -> _Lanes:
        """At least so many lanes, a power of two of blocks."""
        n = BLOCK << (-(-count // BLOCK) - 1).bit_length()
        if n not in self._sims:
            sim = _Lanes(self._plant, n, block=BLOCK)
            if self._numerics.fine > 1:
                sim._module = kernels.load(self._plant, "ground", BLOCK, sim.dtype.name, SERVO_MS / self._numerics.fine)
            sim.set_parameter("slip_speed", self._numerics.slip * sim.parameter("slip_speed"))
            self._sims[n] = sim
        return self._sims[n]

    def rows(self, settings: Sequence[Setting]) -> tuple[np.ndarray, np.ndarray]:
        """Lane parameters (m, R, 4) and parameters of the chassis (m, B) of settings."""
        sim, found = self.of(BLOCK), []
        for s in settings:
            sim._param[:], sim._body[:] = self._neutral
            set_effects(sim, s.effects)
            found.append((sim._param.reshape(-1, 4, BLOCK)[:, :, 0].copy(), sim._body.reshape(-1, BLOCK)[:, 0].copy()))
        return tuple(np.stack(x) for x in zip(*found, strict=True))


class Robot:
    """A backend on the ground."""

    def __init__(self, backend: str, numerics: Numerics = Numerics()) -> None:
        self.backend, self.numerics = backend, numerics

    @property
    def steps(self) -> int:
        """In a servo period."""
        return self.numerics.fine

    def rest(self) -> dict[str, list[float]]:
        """Stiffness, damping and inertia of a front leg's swing and lift at rest, inside units."""
        at = leg_machine(plant(self.backend), "fl", gravity=value("robot.gravity")).at_rest
        return {"stiffness": list(at.stiffness[::2]), "damping": list(at.damping[::2]), "inertia": list(at.mass[::2])}

    def run(self, starts: np.ndarray, drives: Drives, settings: Sequence[Setting], which: np.ndarray, segment: np.ndarray) -> Runs:
        """Lanes from states (n, 29), lane i with settings[which[i]] under the voltages of segment[i]; angles are as sensors have them."""
        n, samples = len(starts), drives.volts.shape[1]
        found = Runs(np.empty((n, samples, 8)), np.empty((n, samples, 3)), np.empty((n, samples, 4)), np.empty((n, STATE)))
        rows = self._kernels.rows(settings)
        for begin in range(0, n, LANES):
            part = slice(begin, min(n, begin + LANES))
            into = Runs(found.angles[part], found.position[part], found.quaternion[part], found.ends[part])
            sim = self._kernels.of(part.stop - part.start)
            self._part(sim, starts[part], drives, settings, rows, which[part], segment[part], into)
        return found

    @cached_property
    def _kernels(self) -> _Kernels:
        return _Kernels(with_effects(plant(self.backend)), self.numerics)

    def _part(self, sim: _Lanes, starts, drives: Drives, settings, rows, which, segment, into: Runs) -> None:
        count = len(starts)
        lanes = np.minimum(np.arange(sim.n), count - 1)
        starts, which, segment = starts[lanes], which[lanes], segment[lanes]
        for array, row in ((sim._param, rows[0]), (sim._body, rows[1])):
            view = array.reshape(sim._blocks, row.shape[1], -1, BLOCK)
            view[...] = row[which].reshape(sim._blocks, BLOCK, row.shape[1], -1).transpose(0, 2, 3, 1)
        shift = np.array([s.shift for s in settings])[which][:, None, None]
        laws = [e.law for s in settings for e in s.effects.effects]
        self._place(sim, starts)
        if any(law.states for law in laws):
            self._lead(sim, starts, drives, shift, segment)
        sensed = any(law.acts == "sense" for law in laws)
        for k in range(drives.volts.shape[1]):
            late = drives.volts[segment, k] - shift * (drives.slopes[segment, k] - 0.5 * shift * drives.bends[segment, k])
            sim.step_voltages(late)
            angles = sim.measured()[0] if sensed else sim.q
            for array, values in zip((into.angles, into.position, into.quaternion), (angles, sim.position, sim.quaternion), strict=True):
                array[:, k] = values[:count]
        ends = np.concatenate([sim.position, sim.quaternion, sim.velocity, sim.angular_velocity, sim.q, sim.qd], 1)
        into.ends[:] = ends[:count]

    @staticmethod
    def _place(sim: BatchSim, x: np.ndarray) -> None:
        sim.set_state(q=x[:, Q], qd=x[:, QD], position=x[:, POSITION], quaternion=x[:, QUATERNION], velocity=x[:, VELOCITY],
                      angular_velocity=x[:, SPIN])  # fmt: skip

    def _lead(self, sim: _Lanes, starts: np.ndarray, drives: Drives, shift: np.ndarray, segment: np.ndarray) -> None:
        """Leads what effects remember along the measured motion up to the starts."""
        sim.keep, x = True, starts.copy()
        for k in range(drives.lead_volts.shape[1]):
            x[:, Q], x[:, QD] = drives.lead_angles[segment, k], drives.lead_rates[segment, k]
            self._place(sim, x)
            sim.step_voltages(drives.lead_volts[segment, k] - shift * drives.lead_slopes[segment, k])
        self._place(sim, starts)
        sim.keep = False
