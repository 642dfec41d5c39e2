"""A machine of 12 Hz with a force of its own, measured by small steps of another method (velocity Verlet with damping)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hamr_dynamics.machine import Machine, linear_machine
from hamr_gap.data.record import Record

STEP = 1e-3  # s
STIFFNESS, DAMPING = (2 * np.pi * 12.0) ** 2, 8.0
MACHINE = linear_machine("test_oscillator", inertia=1.0, stiffness=STIFFNESS, damping=DAMPING)


def oscillator(extra: Callable, seconds: float = 12.0, noise: float = 2e-4) -> tuple[Machine, Record]:
    """The machine and a record of it under noise to 30 Hz; `extra` as of `measured`, noise as a share of the motion."""
    random = np.random.default_rng(3)
    n = int(seconds / STEP)
    spectrum = random.standard_normal((n // 2 + 1, 2)) @ (1.0, 1j) * (np.fft.rfftfreq(n, STEP) < 30.0)
    drive = np.fft.irfft(spectrum, n)
    drive *= np.minimum(np.arange(n) / 500.0, 1.0) * 4000.0 / drive.std()
    return MACHINE, measured(drive, extra, random, noise)


def measured(drive: np.ndarray, extra: Callable, random: np.random.Generator, noise: float, late: int = 0) -> Record:
    """A record under drives (n,) that hold: extra(q, v) is the hidden force; `late` in tenths of a sample is by how much sensors are."""
    q = v = 0.0
    fine = 10
    h, angles = STEP / fine, np.zeros(len(drive) * fine + late)
    for k in range(len(drive) * fine):
        angles[k + late] = q
        v += h * (drive[k // fine] - STIFFNESS * q - DAMPING * v + extra(q, v))
        q += h * v
    seen = angles[: len(drive) * fine : fine, None]
    readings = seen + noise * seen.std() * random.standard_normal(seen.shape)
    return Record(drive[:, None], readings, STEP, MACHINE.channels, held=True)
