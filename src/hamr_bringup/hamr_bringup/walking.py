"""Do the kernel and MuJoCo walk alike? `python -m hamr_bringup.walking` runs three gaits on three surfaces from many jittered starts.

The two share numbers and a contact law and nothing else: forces are clamped between two implicit solves in the kernel, and a
regularised constraint on an elliptic cone in MuJoCo (docs/contact.md). Feet strike at other moments from every start, so
single runs differ; what must agree is the distribution of speeds.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import tyro
from tqdm import tqdm

from hamr_description.names import LEGS, MIRROR, drive_sign
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics.batch import BatchSim
from hamr_sim_full.engines import make_engine as make_full
from hamr_sim_full.mujoco_engine import MujocoEngine
from hamr_sim_residual.engines import make_engine as make_simple

SETTLE = 5  # strides before speed counts
CHUNK = 400  # substeps whose voltages are laid out at a time


@dataclass(frozen=True, slots=True)
class Gait:
    """Open-loop voltages: feet on circles, forward while up.

    Attributes:
        hz: strides per second. swing, lift: amplitudes of the drives, V. phases: of the legs in names.LEGS, in strides.
        strides: that count.
    """

    hz: float
    swing: float
    lift: float
    phases: tuple[float, float, float, float]
    strides: int

    def volts(self, t: np.ndarray, start: np.ndarray) -> np.ndarray:
        """(n, k, 8) V at times t (k,) ms, for starts at phase `start` (n,) strides."""
        out = np.empty((len(start), len(t), 8))
        for i, leg in enumerate(LEGS):
            angle = 2 * np.pi * (t * self.hz / 1e3 + start[:, None] + self.phases[i])
            forward = -MIRROR[leg][0]  # in the leg frame, a positive swing takes the foot backward at the front, forward at the rear
            out[:, :, 2 * i] = value("actuator.neutral_voltage") - forward * drive_sign(leg) * self.swing * np.cos(angle)
            out[:, :, 2 * i + 1] = value("actuator.neutral_voltage") + drive_sign(leg) * self.lift * np.sin(angle)
        return out


TROT, PRONK = (0.0, 0.5, 0.5, 0.0), (0.0, 0.0, 0.0, 0.0)
#: Chosen on the kernel alone, for walking on every surface from any start; fixed before MuJoCo was asked.
GAITS = {
    "trot 10 Hz": Gait(10, 50, 25, TROT, 10),
    "trot 30 Hz": Gait(30, 50, 25, TROT, 20),
    "pronk 20 Hz": Gait(20, 50, 25, PRONK, 20),
}
SURFACES = ("ptfe", "card", "sandpaper")


@dataclass(frozen=True, slots=True)
class Starts:
    """Jittered starts: phase (n,) strides, height (n,) mm above standing, tilt (n, 2) rad, velocity (n, 3) mm/ms."""

    phase: np.ndarray
    height: np.ndarray
    tilt: np.ndarray
    velocity: np.ndarray

    @classmethod
    def random(cls, n: int, seed: int) -> Starts:
        """Any phase; up to 0.3 mm high, 0.01 rad askew, 10 mm/s fast."""
        rng = np.random.default_rng(seed)
        return cls(rng.uniform(0, 1, n), rng.uniform(0, 0.3, n), rng.uniform(-0.01, 0.01, (n, 2)), rng.uniform(-0.01, 0.01, (n, 3)))

    def quaternion(self) -> np.ndarray:
        """(n, 4) wxyz."""
        turn = np.concatenate([np.ones((len(self.phase), 1)), self.tilt / 2, np.zeros((len(self.phase), 1))], axis=1)
        return turn / np.linalg.norm(turn, axis=1, keepdims=True)


def forward(position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """(n,) mm covered along the heading, stride by stride, from position (strides + 1, n, 3) and quaternion (strides + 1, n, 4)."""
    w, x, y, z = np.moveaxis(quaternion[:-1], -1, 0)
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    step = np.diff(position, axis=0)
    return (step[..., 0] * np.cos(yaw) + step[..., 1] * np.sin(yaw)).sum(axis=0)


def kernel_speeds(backend: str, gait: Gait, friction: float, starts: Starts) -> np.ndarray:
    """(n,) mm/s."""
    n = len(starts.phase)
    sim = BatchSim(backend, n, friction=friction)
    sim.set_state(position=sim.position + starts.height[:, None] * (0, 0, 1), quaternion=starts.quaternion(), velocity=starts.velocity)
    poses = []
    for t, counts in _chunks(gait):
        sim.step_voltages(gait.volts(t, starts.phase))
        if counts:
            poses.append((sim.position.copy(), sim.quaternion.copy()))
    return _speed(gait, *map(np.array, zip(*poses, strict=True)))


def mujoco_speeds(backend: str, gait: Gait, friction: float, starts: Starts) -> np.ndarray:
    """(n,) mm/s, one robot after the other."""
    make = make_full if backend == "full" else make_simple
    options = {} if backend == "full" else {"backend": backend}
    engine: MujocoEngine = make(engine="mujoco", friction=friction, **options)
    runs = []
    for i, turn in enumerate(starts.quaternion()):
        engine.reset()
        engine.data.qpos[2] += starts.height[i]
        engine.data.qpos[3:7] = turn
        engine.data.qvel[:3] = starts.velocity[i]
        poses = []
        for t, counts in _chunks(gait):
            for volts in gait.volts(t, starts.phase[i : i + 1])[0]:
                engine.substep(volts)
            if counts:
                poses.append(engine.data.qpos[:7].copy())
        runs.append(poses)
    pose = np.array(runs).transpose(1, 0, 2)
    return _speed(gait, pose[..., :3], pose[..., 3:])


def _chunks(gait: Gait) -> Iterator[tuple[np.ndarray, bool]]:
    """Times of the substeps, a stride in parts; and whether a counted stride begins or ends after them."""
    per_stride = round(1e3 / gait.hz / SERVO_MS)
    for stride in range(SETTLE + gait.strides):
        parts = np.array_split(np.arange(per_stride), -(-per_stride // CHUNK))
        for part in parts:
            last = part is parts[-1]
            yield (stride * per_stride + part + 0.5) * SERVO_MS, last and stride >= SETTLE - 1


def _speed(gait: Gait, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    seconds = gait.strides * round(1e3 / gait.hz / SERVO_MS) * SERVO_MS / 1e3
    return forward(position, quaternion) / seconds


def compare(backend: str, gait: str, surface: str, n: int, *, seed: int = 1) -> dict:
    """One cell: median speeds (mm/s) of both, their difference relative to MuJoCo's, and its 95 % bootstrap interval."""
    starts, friction = Starts.random(n, seed), value(f"contact.friction_{surface}")
    ours, theirs = (speeds(backend, GAITS[gait], friction, starts) for speeds in (kernel_speeds, mujoco_speeds))
    rng = np.random.default_rng(seed)
    medians = [np.median(rng.choice(x, (4000, n)), axis=1) for x in (ours, theirs)]
    scale = np.median(theirs)
    low, high = np.quantile((medians[0] - medians[1]) / abs(scale), (0.025, 0.975))
    difference = (np.median(ours) - scale) / abs(scale)
    return {
        "backend": backend, "gait": gait, "surface": surface, "friction": friction, "starts": n,
        "kernel": float(np.median(ours)), "mujoco": float(scale), "difference": float(difference), "low": float(low), "high": float(high),
        "kernel_spread": float(np.std(ours)), "mujoco_spread": float(np.std(theirs)),
        "ok": bool(abs(difference) <= 0.05 or (low <= 0 <= high and high - low <= 0.1)),
    }  # fmt: skip


def table(cells: list[dict]) -> str:
    """Cells as a Markdown table."""
    heads = ("model", "gait", "surface (mu)", "kernel mm/s", "MuJoCo mm/s", "difference", "95 % interval", "agrees")
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for c in cells:
        speeds = (f"{c[engine]:.1f} +- {c[f'{engine}_spread']:.1f}" for engine in ("kernel", "mujoco"))
        shares = f"{c['difference']:+.1%} | {c['low']:+.1%} .. {c['high']:+.1%}"
        where = f"{c['backend']} | {c['gait']} | {c['surface']} ({c['friction']:g})"
        lines.append(f"| {where} | {' | '.join(speeds)} | {shares} | {'yes' if c['ok'] else 'NO'} |")
    return "\n".join([*lines, ""])


def main(starts: int = 64, backends: tuple[str, ...] = ("simple", "full")) -> None:
    """Compares all cells and writes the table to standard output; a quarter of an hour for 64 starts.

    Args:
        starts: jittered starts per cell. backends: of simple, full.
    """
    cells = [(b, g, s) for b in backends for g in GAITS for s in SURFACES]
    found = [compare(*cell, starts) for cell in tqdm(cells, unit="cell")]
    sys.stdout.write(table(found))


if __name__ == "__main__":
    tyro.cli(main)
