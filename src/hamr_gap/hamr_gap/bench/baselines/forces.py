"""The force that a re-tuned model lacks along the measured motion, and what any other parameters would add to it there.

Inverse dynamics by the machine's own compiled step: from each measured state it says which rate the model would gain until the next,
the readings say which was gained, and the mean force between makes up the difference. Sensors on the actuator's side, if there are
any, stand beside the forces: what they read less what the model says at the measured angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from hamr_dynamics.machine import Machine

from ...naming.prepare import Prepared
from .forced import forced
from .motion import WIDER, Motion, low_pass, motion_of

BATCH = 64  # lanes at a time
WILD = 50.0  # times the usual residual: where a re-tuned model meets a stop that the machine did not, one reading would outweigh all
NUDGE = 1e-3  # of a parameter's prior, or of its scale where that is narrower


@dataclass(frozen=True)
class Forces:
    """Along one record.

    Attributes:
        prepared, motion. home: (rows,) of the re-tuned model.
        residual: (n, outputs) F at the joints, then the other sensors. inverse: (n, joints, joints) rate gained per unit of force.
        known: (n,) readings at which it is known.
    """

    prepared: Prepared
    motion: Motion
    home: np.ndarray
    gained: np.ndarray
    seen: np.ndarray
    inverse: np.ndarray
    residual: np.ndarray
    known: np.ndarray

    @property
    def joints(self) -> int:
        """How many outputs are forces."""
        return len(self.prepared.weighed.model.machine.joints)

    @property
    def fits(self) -> np.ndarray:
        """(n,) readings to fit on."""
        return self.prepared.roles.fit & self.known

    @property
    def judges(self) -> np.ndarray:
        """(n,) readings to select on."""
        return self.prepared.roles.select & self.known

    def rows(self, values: dict[str, float]) -> np.ndarray:
        """(rows,) of the re-tuned model with some rows set to a value."""
        index = self.prepared.weighed.model.machine.parameter_rows.index
        full = self.home.copy()
        for row, x in values.items():
            full[index(row)] = x
        return full

    def added(self, rows: np.ndarray) -> np.ndarray:
        """(K, n, outputs) that (K, rows) other parameters add to what the re-tuned model says; not by what sensors make of angles."""
        found = []
        for at in range(0, len(rows), BATCH):
            gained, seen = _runs(self.prepared, self.motion, rows[at : at + BATCH])
            with np.errstate(invalid="ignore", over="ignore"):  # a law that diverges along the motion is left out by whoever asks
                force = np.linalg.solve(self.inverse, (gained - self.gained)[..., None])[..., 0]
                total = np.concatenate([force, (seen - self.seen)[..., self.joints :]], axis=-1)
            finite = np.isfinite(total).all((1, 2))
            total[finite] = _band(self.prepared, self.motion, total[finite])
            found.append(total.astype(np.float32))
        return np.concatenate(found)

    def misread(self, rows: np.ndarray) -> np.ndarray:
        """(K, n, outputs) by which the residual changes if (K, rows) parameters make the joints' sensors err.

        Their errors are those along the re-tuned model's own run: along the readings they would hold the same noise as the residual.
        """
        model, base = self.prepared.weighed.model, self.prepared.base.fit
        errors = [model.run_rows(row[None])[0] - base.run for row in rows]
        return np.stack([_band(self.prepared, self.motion, self.sensed(e[:, : self.joints])[None])[0] for e in errors]).astype(np.float32)

    def sensed(self, error: np.ndarray) -> np.ndarray:
        """(n, outputs) that errors (n, joints) of the angles make: linear, about rest."""
        machine, step = self.prepared.weighed.model.machine, self.prepared.weighed.model.reading_step
        curve = CubicSpline(np.arange(len(error)) * step, error)
        time, n = curve.x, self.joints
        change = {f.row: f.scale * x for f, x in zip(self.prepared.base.fit.free, self.prepared.base.fit.x, strict=True)}

        def matrix(entries: tuple, name: str) -> np.ndarray:
            own = np.array([[entries[0]]]) if n == 1 else np.array([[entries[0], entries[1]], [entries[1], entries[2]]])
            return own + np.diag([change.get(f"change.{name}.{j}", 0.0) for j in range(n)])

        rest = machine.at_rest
        terms = zip((rest.stiffness, rest.damping, rest.mass), ("stiffness", "damping", "inertia"), strict=True)
        force = sum(curve(time, order) @ matrix(entries, name).T for order, (entries, name) in enumerate(terms))
        return np.hstack([force, -error @ levers(machine)[self.others].T])

    @property
    def others(self) -> list[int]:
        """Indices of the other sensors among the machine's channels that are none of a joint."""
        return [c - self.joints for c in self.prepared.weighed.model.own[self.joints :]]

    def nuisance(self) -> np.ndarray:
        """(K, n, outputs) that a re-tune may still add: its parameters, and biases, gains and one shift of the sensors."""
        base, n = self.prepared.base.fit, self.joints
        nudged = [self.rows({f.row: f.scale * (x + NUDGE * min(f.sd, 1.0))}) for f, x in zip(base.free, base.x, strict=True)]
        found = [*self.added(np.stack(nudged))]
        still = np.zeros_like(self.residual)
        for c in range(n, still.shape[1]):
            for x in (np.ones(len(still)), self.seen[:, c]):
                found.append(still.copy())
                found[-1][:, c] = x
        late = self.sensed(np.gradient(base.run[:, :n], self.prepared.weighed.model.reading_step, axis=0))
        late[:, n:] = 0.0  # all sensors are late together
        scaled = [self.sensed(base.run[:, :n] * (np.arange(n) == j)) for j in self.prepared.weighed.gains if j < n]
        return np.stack([*found, *_band(self.prepared, self.motion, np.stack([late, *scaled]))])

    def noise(self) -> np.ndarray:
        """(outputs,) standard deviation that the sensors' noise leaves in the residual, from white noise sent the same way."""
        model, n = self.prepared.weighed.model, self.joints
        noise = np.random.default_rng(0).normal(size=(len(self.motion.state), len(model.own))) * self.prepared.noise
        smooth = low_pass(noise / (1.0 + self.prepared.base.fit.sensors.gain), min(WIDER * self.motion.cutoff, 0.45))
        mean = smooth[: len(self.residual) * model.mean].reshape(len(self.residual), model.mean, -1).mean(1)
        error = self.sensed(mean[:, :n])
        error[:, n:] += mean[:, n:]
        return _band(self.prepared, self.motion, error[None])[0][self.known].std(0)


def forces_of(prepared: Prepared) -> Forces:
    """The residual force of a record's re-tuned model."""
    model, base, motion = prepared.weighed.model, prepared.base.fit, motion_of(prepared)
    machine, n, mean = model.machine, len(model.machine.joints), model.mean
    home = model.rows(base.free, base.x)[0]
    index = [machine.parameter_rows.index(f"change.preload.{j}") for j in range(n)]
    unit = model.scales.force
    probes = np.tile(home, (1 + n, 1))
    probes[np.arange(n) + 1, index] += unit
    gained, seen = _runs(prepared, motion, probes)
    inverse = np.moveaxis((gained[1:] - gained[0]) / unit, 0, -1)  # [reading, joint that gains, joint that is pushed]
    readings = gained.shape[1]
    rate = np.concatenate([motion.state[:, n : 2 * n], motion.state[-1:, n : 2 * n]])[::mean][: readings + 1]
    missing = np.diff(rate, axis=0) - gained[0]
    tips = motion.tips[: readings * mean].reshape(readings, mean, -1).mean(1)
    residual = np.hstack([np.linalg.solve(inverse, missing[..., None])[..., 0], tips - seen[0][:, n:]])
    residual = _band(prepared, motion, residual[None])[0]
    known = motion.known[: readings * mean].reshape(readings, mean).all(1)
    size = np.abs(residual)
    wild = (size > WILD * np.median(size[known], axis=0)).any(1)
    about = np.convolve(wild, np.ones(2 * int(1.0 / (motion.cutoff * mean)) + 1), "same") > 0.5
    return Forces(prepared, motion, home, gained[0], seen[0], inverse, residual, known & ~about)


def levers(machine: Machine) -> np.ndarray:
    """(other channels, joints) by which the channels that are none of a joint follow the joints, at rest."""
    n, still = len(machine.joints), (0.0,) * len(machine.joints)
    small = 1e-6
    rest = np.array(machine.outputs(still, still), float)
    moved = [np.array(machine.outputs(tuple(small * (i == j) for i in range(n)), still), float) for j in range(n)]
    return np.stack([(x - rest)[n:] / small for x in moved], 1).reshape(-1, n)


def _runs(prepared: Prepared, motion: Motion, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates gained and readings, of the record's channels."""
    model = prepared.weighed.model
    gained, seen = forced(
        model.machine, model.drives, motion.state, rows, step=model.record.step / model.substeps, substeps=model.substeps, mean=model.mean
    )  # fmt: skip
    return gained, seen[:, :, model.own]


def _band(prepared: Prepared, motion: Motion, x: np.ndarray) -> np.ndarray:
    """(K, n, outputs) in the band in which the motion is known."""
    return low_pass(x, motion.cutoff * prepared.weighed.model.mean)
