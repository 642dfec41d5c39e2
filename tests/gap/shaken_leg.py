"""One leg of HAMR-simple shaken by noise, with a law of the library in it, and effects fitted to what it reads."""

from __future__ import annotations

import numpy as np

from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.law import Scales
from hamr_gap.data.record import Record
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.legs import machine_of
from hamr_gap.naming.hypothesis import Start, refine
from hamr_gap.naming.prepare import Prepared

STEP, SECONDS = 0.25, 5.0  # ms, s
NOISE = 1e-3  # of the travel of each sensor
FRICTION = Candidate("coulomb_friction", "presliding", (0,))
BESIDE = (Candidate("quadratic_damping", "square", (1,)), Candidate("drive_lag", "first_order", (1,)))


def shaken(law: str, rows: dict[str, float], volts: tuple[float, float] = (9.0, 9.0), **beside: dict[str, float]) -> Record:
    """A leg with some rows of a law on, and of others by name, driven by noise to 40 Hz: 40 waves of some amplitude, V, in each joint."""
    leg = machine_of("simple", "fl")
    n = int(SECONDS * 1e3 / STEP)
    random, time = np.random.default_rng(2), np.arange(n) * STEP * 1e-3
    waves = [(random.uniform(3.0, 40.0), random.uniform(0.0, 2 * np.pi, 2)) for _ in range(40)]
    drives = np.array(volts) * sum(np.sin(2 * np.pi * hz * time[:, None] + phase) for hz, phase in waves)
    row = leg.neutral(Scales(0.06, 0.1, 0.07, 60.0, 12e3))
    for each, own in {law: rows, **beside}.items():
        for name, x in own.items():
            row[leg.parameter_rows.index(f"{each}.{name}")] = x
    truth = machine_kernel.simulate(leg, np.repeat(drives, 5, axis=0), row[None], step=STEP / 5, substeps=1)[0][::5]
    readings = truth + NOISE * np.ptp(truth, axis=0) * random.standard_normal(truth.shape)
    return Record(drives, readings, STEP, leg.channels)


def fitted(prepared: Prepared, *effects: Candidate):
    free = (*prepared.base.fit.free, *effect_parameters(effects, prepared.weighed.model.scales))
    x = np.array([*prepared.base.fit.x, *(f.center or 1e-3 * f.sd for f in free[len(prepared.base.fit.x) :])])
    return refine(prepared.weighed, prepared.judged, Start(effects, free, x, np.inf))
