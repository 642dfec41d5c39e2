"""Sensors of rates and accelerations: a tachometer on a motor, an accelerometer on a spring, against other code and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from hamr_description.errors import BagError
from hamr_dynamics import machine_kernel
from hamr_dynamics.machine import linear_machine, with_motion
from hamr_gap.data.columns import record_of
from hamr_gap.data.motion import coordinates, measured_by
from hamr_gap.data.record import Record
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.scales import scales_of
from hamr_gap.fitting.weighed import Weighed
from hamr_gap.judging.analyse import analyse
from hamr_gap.judging.unexplained import shared
from hamr_gap.legs import machine_of
from hamr_gap.naming.candidates import candidates
from hamr_gap.naming.prepare import prepare
from hamr_gap.plants import run

MODEL = """
from hamr_dynamics.machine import linear_machine

def motor():
    return linear_machine("motor", inertia=1.2, damping=1.6, joint="shaft", units={"F": "N*m", "Q": "rad", "T": "s", "U": "N*m"})
"""
UNITS = {"F": "N*m", "Q": "rad", "T": "s", "U": "N*m"}
MOTOR = with_motion(linear_machine("motor", inertia=1.0, damping=2.0, joint="shaft", units=UNITS))
SPRING = with_motion(linear_machine("spring", inertia=1.0, stiffness=900.0, damping=6.0, joint="mass", units=UNITS))


def noise(n: int, hz: float, step: float, seed: int = 0) -> np.ndarray:
    """(n,) of unit rms below a frequency."""
    x = sosfilt(butter(3, hz, fs=1.0 / step, output="sos"), np.random.default_rng(seed).standard_normal(n))
    return x / x.std()


def moved(u: np.ndarray, step: float, stiffness: float, damping: float, *, friction: float = 0.0, cubic: float = 0.0) -> np.ndarray:
    """(n, 3) coordinate, rate and acceleration of one kilogramme under held drives, by small steps that know nothing of the library."""
    q = v = 0.0
    fine, seen = 20, np.empty((len(u), 3))
    h = step / fine
    for i, drive in enumerate(u):
        push = drive - stiffness * q - cubic * q**3 - damping * v
        seen[i] = q, v, push - friction * np.tanh(v / 1e-3)
        for _ in range(fine):
            v += h * (drive - stiffness * q - cubic * q**3 - damping * v)
            v = np.sign(v) * max(abs(v) - h * friction, 0.0)
            q += h * v
    return seen


def test_channels_are_derivatives_of_each_other_and_obey_the_equations():
    step, fine = 1e-3, 8
    u = 50.0 * noise(3000, 6.0, step)
    parameters = SPRING.neutral(scales_of(SPRING, Record(u[:, None], moved(u, step, 900.0, 6.0), step, SPRING.channels)))
    read = machine_kernel.simulate(SPRING, np.repeat(u, fine)[:, None], parameters[None], step=step / fine, substeps=fine)[0]
    q, v, a = read[1:].T
    assert np.gradient(q, step)[1:-1] == pytest.approx(v[1:-1], abs=1e-3 * v.std())
    assert np.gradient(v, step)[1:-1] == pytest.approx(a[1:-1], abs=1e-2 * a.std())
    # a held drive jumps at each reading, which is between the two steps
    assert a == pytest.approx(0.5 * (u[1:] + u[:-1]) - 900.0 * q - 6.0 * v, abs=1e-3 * a.std())


def test_of_two_joints_each_has_its_own():
    leg = with_motion(machine_of("simple", "fl"))
    assert [leg.motion_of(name) for name in leg.channels] == [(0, 0), (1, 0), None, None, (0, 1), (1, 1), (0, 2), (1, 2)]
    assert leg.channels[-1] == "fl_lift_acceleration"
    plain = machine_of("simple", "fl")
    assert [plain.motion_of(name) for name in plain.channels] == [(0, 0), (1, 0), None, None]


@pytest.mark.parametrize("order", [1, 2])
def test_coordinates_are_integrals_as_far_as_a_bias_lets_them_be(order):
    """Of a spring's motion, in two stretches with a gap, by sensors with a bias."""
    step, n = 1e-3, 8000
    seen = moved(30.0 * noise(n, 6.0, step), step, 900.0, 6.0)
    read = seen[:, order : order + 1] + 0.1 * seen[:, order].std()
    read[2000:2003] = np.nan
    record = Record(np.ones((n, 1)), read, step, (SPRING.channels[order],), breaks=(5000,))
    found = coordinates(SPRING, record)[:, 0]
    assert np.isnan(found[2000:2003]).all() and np.isfinite(np.delete(found, slice(2000, 2003))).all()
    assert np.nanstd(found - seen[:, 0]) < 0.2 * seen[:, 0].std()
    assert scales_of(SPRING, record).coordinate == pytest.approx(seen[:, 0].std(), rel=0.1)


def test_the_most_direct_sensor_says_where_a_joint_is():
    record = Record(np.zeros((9, 1)), np.arange(27.0).reshape(9, 3), 0.1, ("mass", "mass_rate", "mass_acceleration"))
    assert measured_by(SPRING, record) == {0: (0, 0)}
    np.testing.assert_array_equal(coordinates(SPRING, record)[:, 0], record.readings[:, 0])


def test_sensors_that_are_not_there_lack_nothing():
    record = Record(np.random.default_rng(0).standard_normal((9, 1)), np.zeros((9, 1)), 0.1, ("shaft_rate",))
    named = {c.effect for c in candidates(MOTOR, record)}
    assert "coulomb_friction" in named and not {"sensor_nonlinearity", "sensor_quantisation"} & named


def test_sensors_act_where_there_is_one():
    leg = with_motion(machine_of("simple", "fl"))
    record = Record(np.random.default_rng(0).standard_normal((9, 2)), np.zeros((9, 2)), 0.1, ("fl_lift", "fl_swing_rate"))
    assert {c.joints for c in candidates(leg, record) if c.effect == "sensor_nonlinearity"} == {(1,)}
    assert {c.joints for c in candidates(leg, record) if c.effect == "cubic_stiffness"} == {(0,), (1,), (0, 1)}


def test_a_rate_is_no_second_sensor_of_the_other_side():
    """Which would show the same as the first, where a coordinate's derivative shows nothing of it."""
    step, n = 2e-3, 4000
    u = 60.0 * noise(n, 8.0, step)
    seen = moved(u, step, 900.0, 6.0)[:, :2]
    read = seen * (1.0 + 1e-3 * np.random.default_rng(1).standard_normal((n, 2)))
    prepared = prepare(SPRING, Record(u[:, None], read, step, ("mass", "mass_rate"), held=True))
    assert len(shared(prepared.weighed, prepared.judged, prepared.base.fit)) == 0
    assert prepared.weighed.gains == (1,)


@pytest.mark.parametrize(("channels", "biased"), [
    (("shaft", "shaft_rate"), (1,)), (("shaft_rate",), ()), (("shaft_rate", "shaft_acceleration"), (1,)),
])  # fmt: skip
def test_a_sensor_from_which_pieces_start_has_no_bias_of_its_own(channels, biased):
    """The start has it."""
    step, n = 5e-3, 2000
    u = noise(n, 1.0, step)
    read = moved(u, step, 0.0, 2.0)[:, [MOTOR.channels.index(name) for name in channels]]
    record = Record(u[:, None], read, step, channels, rest=False)
    model = Model(MOTOR, record, 1, 1, scales_of(MOTOR, record))
    assert model.starts
    assert Weighed(model, np.ones_like(read, bool), np.ones(len(channels)), ()).biased == biased


def test_a_tachometer_shows_dry_friction(tmp_path):
    """From a user's file and tables to the report, with a model that is off besides."""
    (tmp_path / "model.py").write_text(MODEL)
    step, n = 5e-3, 6000
    for seed in (0, 1):
        u = 3.0 * noise(n, 1.0, step, seed)
        seen = moved(u, step, 0.0, 2.0, friction=1.0)[:, 1]
        seen += 1e-3 * seen.std() * np.random.default_rng(seed).standard_normal(n)
        np.savez(tmp_path / f"{seed}.npz", **{"time": step * np.arange(n), "drive": u, "shaft_rate [rad/s]": seen})
    found = run(f"{tmp_path}/model.py:motor", [tmp_path / "0.npz"], tmp_path / "out", holdout=[tmp_path / "1.npz"])
    assert found["verdict"] == "named"
    ((effect,),) = (answer["effects"] for answer in found["set"])
    assert effect["effect"] == "coulomb_friction"
    assert effect["parameters"]["level"]["value"] == pytest.approx(1.0, rel=0.03)
    assert found["shown"]["closed"] > 0.99
    assert found["shown"]["machines"]["motor"]["channels"]["shaft_rate"]["unit"] == "rad/s"
    silent = {s["effect"] for s in found["not_observable"]}
    assert "sensor_quantisation" in silent
    assert not silent & {"ground_friction", "added_mass", "tether_force"}  # no shaft walks
    assert "shaft_rate" in (tmp_path / "out" / "report.html").read_text()


def test_an_accelerometer_shows_a_spring_that_hardens():
    step, n = 2e-3, 8000
    u = 60.0 * noise(n, 8.0, step)
    seen = moved(u, step, 900.0, 6.0, cubic=4e4)
    read = seen[:, 2:] + 2e-3 * seen[:, 2].std() * np.random.default_rng(1).standard_normal((n, 1)) + 0.3
    verdict = analyse(SPRING, Record(u[:, None], read, step, ("mass_acceleration",), held=True, rest=False)).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert effect.effect == "cubic_stiffness"
    assert effect.parameters["cubic"]["mass"].value == pytest.approx(4e4, rel=0.03)


def test_tables_may_have_them_in_their_units(tmp_path):
    np.savez(tmp_path / "a.npz", **{"time": 0.01 * np.arange(3), "drive": np.ones(3), "shaft_rate [rpm]": np.array([0.0, 30.0, 60.0])})
    record = record_of(MOTOR, tmp_path / "a.npz")
    assert record.channels == ("shaft_rate",) and record.readings[:, 0] == pytest.approx(np.pi * np.arange(3))
    micro = linear_machine("piezo", inertia=1.0, stiffness=1.0, joint="tip", units={"F": "um", "Q": "um", "T": "s", "U": "V"})
    for unit, factor in (("um", 1.0), ("mm", 1e3), ("m", 1e6)):  # of a machine whose own unit is not one of SI
        np.savez(tmp_path / "c.npz", **{"time": 0.01 * np.arange(3), "drive": np.ones(3), f"tip [{unit}]": np.arange(3.0)})
        assert record_of(micro, tmp_path / "c.npz").readings[:, 0] == pytest.approx(factor * np.arange(3))
    for name, said in (("shaft_rate [g]", "cannot be made rad/s, as motor has it"), ("speed", "no column for the sensor shaft;")):
        np.savez(tmp_path / "b.npz", **{"time": 0.01 * np.arange(3), "drive": np.ones(3), name: np.ones(3)})
        with pytest.raises(BagError, match=said):
            record_of(MOTOR, tmp_path / "b.npz")
