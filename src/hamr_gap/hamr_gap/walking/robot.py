"""The whole robot as lanes: states, recorded voltages and parameter sets in, angles and poses out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import kernels
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.machine import leg_machine
from hamr_dynamics.plant import Plant, plant, with_effects
from hamr_dynamics.set_effects import set_effects

from ..fitting.threads import at_once
from .segments import POSITION, QD, QUATERNION, SPIN, STATE, VELOCITY, Q
from .setting import Setting

LANES, BLOCK = 512, 16  # simulated at once by a thread, and in a block


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

    def late(self, shifts: np.ndarray) -> np.ndarray:
        """(u, s, k, steps, 8) voltages that act later by each of `shifts` (u,) ms."""
        shift = shifts[:, None, None, None, None]
        return self.volts - shift * (self.slopes - 0.5 * shift * self.bends)

    def lead(self, shifts: np.ndarray) -> np.ndarray:
        """(u, s, j, steps, 8) likewise, before."""
        return self.lead_volts - shifts[:, None, None, None, None] * self.lead_slopes


class _Lanes(BatchSim):
    """Robots whose effects may keep what they remember while their motion is set."""

    keep = False

    def _forget(self, mask) -> None:
        if not self.keep:
            super()._forget(mask)

    def first(self, count: int) -> _Lanes:
        """The blocks that so many lanes need, in the same memory."""
        some, blocks = copy(self), -(-count // self.block)
        some.n, some._blocks = blocks * self.block, blocks
        for name in ("_state", "_target", "_param", "_base", "_body", "_seen", "_no_drive"):
            setattr(some, name, getattr(self, name)[:blocks])
        return some

    def furnish(self, rows: tuple[np.ndarray, np.ndarray], which: np.ndarray) -> None:
        """Gives lane i the parameters rows[...][which[i]] (`_Kernels.rows`)."""
        for array, row in zip((self._param, self._body), rows, strict=True):
            view = array.reshape(self._blocks, *row.shape[1:], BLOCK)
            view[...] = row[0][..., None]
            differ = (row != row[0]).any((0, 2))  # few of some five hundred
            own = row[:, differ][which].reshape(self._blocks, BLOCK, differ.sum(), row.shape[2])
            view[:, differ] = own.transpose(0, 2, 3, 1)

    def place(self, x: np.ndarray) -> None:
        """Sets states (n, 29)."""
        self.set_state(q=x[:, Q], qd=x[:, QD], position=x[:, POSITION], quaternion=x[:, QUATERNION], velocity=x[:, VELOCITY],
                       angular_velocity=x[:, SPIN])  # fmt: skip

    def lead(self, starts: np.ndarray, lead: np.ndarray, drive: tuple[np.ndarray, np.ndarray], drives: Drives) -> None:
        """Leads what effects remember along the measured motion up to the starts (n, 29); lane i has lead[drive[0][i], drive[1][i]]."""
        self.keep, x, segment = True, starts.copy(), drive[1]
        for k in range(lead.shape[2]):
            x[:, Q], x[:, QD] = drives.lead_angles[segment, k], drives.lead_rates[segment, k]
            self.place(x)
            self.step_voltages(lead[(*drive, k)])
        self.place(starts)
        self.keep = False


class _Kernels:
    """Simulators of a plant, one for each thread that asks."""

    def __init__(self, plant: Plant, numerics: Numerics) -> None:
        self._plant, self._numerics = plant, numerics
        self._idle: list[_Lanes] = []
        with self.lanes(BLOCK) as one:
            self._neutral = one._param.copy(), one._body.copy()

    @contextmanager
    def lanes(self, count: int) -> Iterator[_Lanes]:
        """A simulator of at least so many lanes, at most LANES, that nobody else uses."""
        try:
            sim = self._idle.pop()
        except IndexError:
            sim = self._made()
        yield sim.first(count)
        self._idle.append(sim)

    def _made(self) -> _Lanes:
        sim = _Lanes(self._plant, LANES, block=BLOCK)
        if self._numerics.fine > 1:
            sim._module = kernels.load(self._plant, "ground", BLOCK, sim.dtype.name, SERVO_MS / self._numerics.fine)
        sim.set_parameter("slip_speed", self._numerics.slip * sim.parameter("slip_speed"))
        return sim

    def rows(self, settings: Sequence[Setting]) -> tuple[np.ndarray, np.ndarray]:
        """Lane parameters (m, R, 4) and parameters of the chassis (m, B, 1) of settings."""
        found = []
        with self.lanes(BLOCK) as sim:
            for s in settings:
                sim._param[:], sim._body[:] = self._neutral
                set_effects(sim, s.effects)
                found.append((sim._param.reshape(-1, 4, BLOCK)[:, :, 0].copy(), sim._body.reshape(-1, 1, BLOCK)[:, :, 0].copy()))
        return tuple(np.stack(x) for x in zip(*found, strict=True))


class Robot:
    """A backend on the ground."""

    def __init__(self, backend: str, numerics: Numerics = Numerics()) -> None:
        self.backend, self.numerics = backend, numerics

    @property
    def steps(self) -> int:
        """In a servo period."""
        return self.numerics.fine

    def finer(self) -> Robot:
        """The same in half the steps."""
        return Robot(self.backend, replace(self.numerics, fine=2 * self.numerics.fine))

    def rest(self) -> dict[str, list[float]]:
        """Stiffness, damping and inertia of a front leg's swing and lift at rest, inside units."""
        at = leg_machine(plant(self.backend), "fl", gravity=value("robot.gravity")).at_rest
        return {"stiffness": list(at.stiffness[::2]), "damping": list(at.damping[::2]), "inertia": list(at.mass[::2])}

    def run(self, starts: np.ndarray, drives: Drives, settings: Sequence[Setting], which: np.ndarray, segment: np.ndarray) -> Runs:
        """Lanes from states (n, 29), lane i with settings[which[i]] under the voltages of segment[i]; angles are as sensors have them."""
        n, samples = len(starts), drives.volts.shape[1]
        found = Runs(np.empty((n, samples, 8)), np.empty((n, samples, 3)), np.empty((n, samples, 4)), np.empty((n, STATE)))
        rows = self._kernels.rows(settings)
        shifts, shift = np.unique([s.shift for s in settings], return_inverse=True)
        laws = [e.law for s in settings for e in s.effects.effects]
        late, lead = drives.late(shifts), drives.lead(shifts) if any(law.states for law in laws) else None
        sensed = any(law.acts == "sense" for law in laws)

        def ran(begin: int) -> None:
            lanes = slice(begin, min(n, begin + LANES))
            with self._kernels.lanes(lanes.stop - begin) as sim:
                own = np.minimum(np.arange(begin, begin + sim.n), n - 1)  # the last again, up to a whole block
                sim.furnish(rows, which[own])
                sim.place(starts[own])
                drive = shift[which[own]], segment[own]
                if lead is not None:
                    sim.lead(starts[own], lead, drive, drives)
                self._advance(sim, late, drive, sensed, Runs(*(getattr(found, f.name)[lanes] for f in fields(found))))

        at_once(ran, range(0, n, LANES))
        return found

    @cached_property
    def _kernels(self) -> _Kernels:
        return _Kernels(with_effects(plant(self.backend)), self.numerics)

    @staticmethod
    def _advance(sim: _Lanes, late: np.ndarray, drive: tuple[np.ndarray, np.ndarray], sensed: bool, into: Runs) -> None:
        count, samples = into.angles.shape[:2]
        for k in range(samples):
            sim.step_voltages(late[(*drive, k)])
            angles = sim.measured()[0] if sensed else sim.q
            for array, values in zip((into.angles, into.position, into.quaternion), (angles, sim.position, sim.quaternion), strict=True):
                array[:, k] = values[:count]
        ends = np.concatenate([sim.position, sim.quaternion, sim.velocity, sim.angular_velocity, sim.q, sim.qd], 1)
        into.ends[:] = ends[:count]
