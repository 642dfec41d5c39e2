"""What was measured in a run, as numpy arrays."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, slots=True)
class Pose:
    """Base pose, at its own times: time (m,) s, position (m, 3) m in the world, quaternion (m, 4) xyzw."""

    time: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray


@dataclass(frozen=True, slots=True)
class Recording:
    """Samples of one run: columns in canonical joint order, SI units, float64, one row per servo sample.

    Attributes:
        time: (n,) s, sim time, strictly increasing.
        voltages: (n, 8) V, held from each sample to the next.
        angles: (n, 8) rad, hip angles.
        deflections: (n, 8) m, actuator tips; None unless declared measured (it is by default).
        rates, deflection_rates: (n, 8) rad/s, m/s; None unless declared measured or truth was asked for.
        torque, acceleration, force: (n, 8) N m, rad/s^2, N; None unless truth was asked for; simulation only.
        pose: base pose; None unless declared measured.
        environment: "ground" or "suspended"; empty if the bag does not say.
        sample_hz: nominal samples per second.
    """

    time: np.ndarray
    voltages: np.ndarray
    angles: np.ndarray
    environment: str
    sample_hz: float
    deflections: np.ndarray | None = None
    rates: np.ndarray | None = None
    deflection_rates: np.ndarray | None = None
    torque: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    force: np.ndarray | None = None
    pose: Pose | None = None

    def __len__(self) -> int:
        return len(self.time)

    @property
    def pieces(self) -> list[slice]:
        """The stretches without a gap, each a slice of rows; one slice for a complete recording."""
        cuts = np.flatnonzero(np.diff(self.time) * self.sample_hz > 1.5) + 1
        edges = [0, *cuts.tolist(), len(self.time)]
        return [slice(a, b) for a, b in zip(edges, edges[1:], strict=False)]


def digest(recording: Recording) -> str:
    """Hash of the numbers of a recording, 64 hex digits; equal for equal numbers, however the bag stores them."""
    sha = hashlib.sha256()
    for field in fields(recording):
        value = getattr(recording, field.name)
        parts = [getattr(value, f.name) for f in fields(value)] if isinstance(value, Pose) else [value]
        for part in parts:
            if isinstance(part, np.ndarray):
                sha.update(f"{field.name}{part.shape}".encode())
                sha.update(np.ascontiguousarray(part, "<f8").tobytes())
    return sha.hexdigest()
