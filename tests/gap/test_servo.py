"""A servo as people log it: gears that stick under load, an encoder of 4096 counts, a clock that is some per cent uneven.

Its friction is that of Duclusaud et al. (Extended friction models for the physics simulation of servo actuators, ICRA 2025): it grows
with the load of the gears and near standstill. A model without it is lost within seconds, and about a run that is lost nothing is linear.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from hamr_dynamics.machine import Machine, Terms
from hamr_dynamics.scalar import cos, sin
from hamr_gap.analyse import analyse
from hamr_gap.columns import record_of
from hamr_gap.model import Model
from hamr_gap.readings import sensor_noise
from hamr_gap.record import joined
from hamr_gap.scales import scales_of

INERTIA, WEIGHT, DAMPING, GAIN = 0.0067, 0.48, 0.04, 0.096  # kg m^2, N m at a right angle, N m s, N m/V
COUNT, STEP, VOLTS, SPEED = 2.0 * math.pi / 4096, 5.3e-3, 7.4, 0.3  # rad, s, V, rad/s


def servo() -> Machine:
    """As a data sheet has it: inertia, damping and gain some per cent off, and no dry friction."""
    inertia, damping, gain = 0.0075, 0.035, 0.1

    def terms(q, v_mid, v, u) -> Terms:
        force = gain * u[0] - WEIGHT * sin(q[0]) - damping * v[0]
        return Terms((inertia,), (0.0,), (force,), (WEIGHT * cos(q[0]),), (damping,), (gain * u[0],))

    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "V"}
    return Machine("servo", ("arm",), ("arm",), terms, lambda q, slip: (q[0],), units, dict.fromkeys("FQTU", 1.0))


def sweep(time: float) -> float:
    return math.sin(time * time)


def sines(time: float) -> float:
    return math.sin(time) + 0.8 * math.sin(5.0 * time)


def logged(path, goal, *, level: float, share: float, boost: float, seconds: float = 6.0, seed: int = 1):
    """Table of 17 V/rad towards a goal, by steps of 0.1 ms that know when the arm sticks, of no library.

    Args:
        level, share, boost: friction is (level + share |drive|) (1 + boost / (1 + (rate / 0.3)^2)), N m.
    """
    random, q, v, time, rows = np.random.default_rng(seed), 0.0, 0.0, 0.0, []
    while time < seconds:
        seen = round(q / COUNT) * COUNT
        volts = max(-VOLTS, min(VOLTS, 17.0 * (goal(time) - seen)))
        rows.append((time, volts, seen))
        step = STEP * (1.0 + min(0.12, max(-0.12, 0.04 * random.standard_normal())))
        for _ in range(50):
            friction = (level + share * abs(GAIN * volts)) * (1.0 + boost / (1.0 + (v / SPEED) ** 2))
            free = v + step / 50 * (GAIN * volts - WEIGHT * math.sin(q) - DAMPING * v) / INERTIA
            v = math.copysign(max(abs(free) - step / 50 * friction / INERTIA, 0.0), free)
            q += step / 50 * v
        time += step
    np.savetxt(path, rows, delimiter=",", header="time,drive,arm", comments="")
    return path


def test_rounding_is_noise_even_where_evened_readings_hide_it(tmp_path):
    """An arm that stands still most of the time shows no noise between its counts; splines through them are no multiples of one."""
    record = record_of(servo(), logged(tmp_path / "log.csv", sweep, level=0.2, share=0.2, boost=1.0))
    assert record.uneven > 0.05
    assert sensor_noise(record) == pytest.approx([COUNT / math.sqrt(12.0)], rel=0.01)
    assert joined([record, record]).rounding == record.rounding


def test_a_short_piece_is_no_longer_than_a_share_of_the_record(tmp_path):
    """The arm swings at 1.3 Hz; four periods of that are half of the record, and as lost as all of it."""
    machine = servo()
    record = record_of(machine, logged(tmp_path / "log.csv", sweep, level=0.02, share=0.25, boost=0.0))
    free = Model(machine, record, 1, 1, scales_of(machine, record))
    assert free.pieces is None or free.pieces.forgotten
    pieces = analyse(machine, record).prepared.weighed.in_pieces.model.pieces
    assert np.max(pieces.stop - pieces.first) * STEP < record.span / 25


@pytest.mark.parametrize(
    ("goal", "friction", "form"),
    [
        (sweep, {"level": 0.01, "share": 0.15, "boost": 1.0}, ("stribeck_friction", "loaded")),
        (sines, {"level": 0.02, "share": 0.25, "boost": 0.0}, ("coulomb_friction", "loaded")),
    ],
)
def test_gears_that_stick_under_load_are_named(tmp_path, goal, friction, form):
    """Six seconds each, of which the free run about the re-tuned model is off by a third of the motion."""
    verdict = analyse(servo(), record_of(servo(), logged(tmp_path / "log.csv", goal, **friction))).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert (effect.effect, effect.form) == form
    assert effect.parameters["share"]["arm"].value == pytest.approx(friction["share"], rel=0.25)
