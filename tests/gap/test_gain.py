"""When the gain of a drive can be told from everything else, and is re-tuned."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine, Terms, linear_machine
from hamr_dynamics.scalar import cos, sin
from hamr_gap.data.record import Record
from hamr_gap.fitting.parameters import changes
from hamr_gap.judging.analyse import analyse
from hamr_gap.legs import machine_of

INERTIA, WEIGHT, DAMPING, GAIN = 0.005, 0.5, 0.03, 0.1  # kg m^2, N m at a right angle, N m s, N m/V
USUAL = Scales(0.5, 0.8, 0.3, 4.0, 30.0)


def arm() -> Machine:
    def terms(q, v_mid, v, u) -> Terms:
        force = GAIN * u[0] - WEIGHT * sin(q[0]) - DAMPING * v[0]
        return Terms((INERTIA,), (0.0,), (force,), (WEIGHT * cos(q[0]),), (DAMPING,), (GAIN * u[0],))

    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "V"}
    return Machine("arm", ("arm",), ("arm",), terms, lambda q, slip: (q[0],), units, dict.fromkeys("FQTU", 1.0))


def free_gains(machine: Machine, driven: list[bool]) -> list[str]:
    return [f.row for f in changes(machine, USUAL, driven) if f.row.startswith("change.gain")]


def test_a_gain_is_free_where_a_record_tells_it():
    line = linear_machine("line", inertia=1.0, stiffness=4.0, damping=0.3, gain=2.0, preload=0.1)
    assert free_gains(line, [True]) == []  # a weaker drive, or more of everything else
    assert free_gains(arm(), [True]) == ["change.gain.0"]
    assert free_gains(arm(), [False]) == []
    assert free_gains(machine_of("simple", "fl"), [False, True]) == ["change.gain.1"]


@pytest.mark.parametrize(("lever", "whirl"), [(0.5, 0.0), (0.0, 1e-3)])
def test_an_inertia_or_a_force_of_motion_that_bends_tells_it_too(lever, whirl):
    def terms(q, v_mid, v, u) -> Terms:
        mass = INERTIA * (1.0 + lever * q[0] * q[0])
        return Terms((mass,), (whirl * v[0] * v[0],), (GAIN * u[0] - 0.1 * q[0] - DAMPING * v[0],), (0.1,), (DAMPING,), (GAIN * u[0],))

    machine = Machine("crank", ("crank",), ("crank",), terms, lambda q, slip: (q[0],), {}, dict.fromkeys("FQTU", 1.0))
    assert free_gains(machine, [True]) == ["change.gain.0"]


def test_a_drive_that_does_next_to_nothing_is_no_answer_to_a_joint_that_sticks():
    """A re-tune had it do a twentieth of what it does, and the names that were looked for about that were wrong."""
    step, fine, q, v, friction = 5e-3, 40, 0.0, 0.0, 0.2
    random = np.random.default_rng(2)
    drive = 2.0 * np.sin(np.cumsum(random.uniform(0.005, 0.05, 3000))) + 2.0 * np.sin(0.01 * np.arange(3000))
    seen, h = np.empty(len(drive)), step / fine
    for i, u in enumerate(drive):
        seen[i] = q
        for _ in range(fine):
            v += h * (GAIN * u - WEIGHT * math.sin(q) - DAMPING * v) / INERTIA
            v = math.copysign(max(abs(v) - h * friction / INERTIA, 0.0), v)  # friction holds what it can
            q += h * v
    record = Record(drive[:, None], (seen + random.normal(0.0, 1e-3, len(seen)))[:, None], step, ("arm",), held=True)
    found = analyse(arm(), record)
    assert found.verdict.set[0].effects[0].effect == "coulomb_friction"
    assert found.verdict.set[0].effects[0].parameters["level"]["arm"].value == pytest.approx(friction, rel=0.1)
    tuned = dict(zip((f.row for f in found.prepared.base.fit.free), found.prepared.base.fit.x, strict=True))
    assert tuned["change.gain.0"] == -0.5
    assert any("as little as it may of: gain of arm" in note for note in found.verdict.notes)


def test_a_weak_motor_under_a_known_weight_is_a_parameter():
    """Of stiffness, damping and inertia no change makes an arm's weight less: it was called a spring that changes with the angle."""
    step, fine, q, v = 5e-3, 20, 0.0, 0.0
    random = np.random.default_rng(2)
    drive = 2.0 * np.sin(np.cumsum(random.uniform(0.005, 0.05, 4000))) + 2.0 * np.sin(0.01 * np.arange(4000))
    seen = np.empty(len(drive))
    for i, u in enumerate(drive):
        seen[i] = q
        for _ in range(fine):
            v += step / fine * (0.8 * GAIN * u - WEIGHT * math.sin(q) - DAMPING * v) / INERTIA
            q += step / fine * v
    record = Record(drive[:, None], (seen + random.normal(0.0, 1e-3, len(seen)))[:, None], step, ("arm",), held=True)
    verdict = analyse(arm(), record).verdict
    assert verdict.verdict == "parameters_only"
    assert verdict.parameters["gain"]["arm"].value == pytest.approx(-0.2, abs=0.01)
