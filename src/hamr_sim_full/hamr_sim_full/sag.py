"""How far HAMR-full sinks on its legs, by letting it settle."""

from __future__ import annotations

import numpy as np

from hamr_description.numbers import value
from hamr_description.posture import stand_height
from hamr_description.rates import SERVO_MS
from hamr_dynamics.batch import BatchSim

from .parameters import FLEXURES
from .plants import full

DAMPING = 20.0  # times the flexures' own: rest does not depend on it, the time to get there does
TIME_MS, CHUNK = 400.0, 400


def static_sag(*, rail: bool, friction: float) -> float:
    """Drop of the chassis, mm, from neutral legs just touching the ground to rest at neutral voltage.

    With friction the answer depends on how the load came on: feet that stick sideways carry part of it.
    """
    sim = BatchSim(full(rail=rail), 1, friction=friction)
    for flexure in FLEXURES:
        sim.set_parameter(f"b_{flexure}", DAMPING * sim.parameter(f"b_{flexure}"))
    neutral = np.full((1, CHUNK, 8), value("actuator.neutral_voltage"))
    for _ in range(round(TIME_MS / SERVO_MS / CHUNK)):
        sim.step_voltages(neutral)
    return stand_height() - float(sim.position[0, 2])
