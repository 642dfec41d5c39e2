"""The Engine interface on all three MuJoCo models: rows, base, counters, determinism, symmetry, end stops."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mujoco_models import ENGINES

from hamr_description.names import JOINTS, LEGS, drive_sign, joint_signs, torque_sign
from hamr_sim_full.mujoco_engine import stop_force
from hamr_sim_full.mujoco_loop import compiled_step_loop

BACKENDS = tuple(ENGINES)
PERIOD = 80
STEP_S = 50e-6
POSITION, VELOCITY, DEFLECTION, DEFLECTION_RATE, TORQUE, FORCE, ACCELERATION = range(7)
DRIVE_SIGN = np.repeat([drive_sign(leg) for leg in LEGS], 2)
ANGLE_SIGN = np.array([sign for leg in LEGS for sign in joint_signs(leg)])


def sample(engine) -> np.ndarray:
    out = np.full((7, 8), np.nan)
    engine.measure(out)
    return out


def base(engine) -> np.ndarray:
    out = np.full(13, np.nan)
    engine.base(out)
    return out


def wave(amplitude: float, hz: float, steps: int, ramp_ms: float = 20.0) -> np.ndarray:
    """Trot-like voltages (steps, 8): swings and lifts a quarter cycle apart, diagonal legs half a cycle."""
    t = 50e-3 * np.arange(steps)
    phase = np.array([0, np.pi / 2, np.pi, 3 * np.pi / 2, np.pi, 3 * np.pi / 2, 0, np.pi / 2])
    envelope = amplitude * np.minimum(1.0, t / ramp_ms)
    return 112.5 + envelope[:, None] * DRIVE_SIGN * np.sin(2e-3 * np.pi * hz * t[:, None] + phase)


def run(engine, volts) -> np.ndarray:
    """Samples after every substep (steps, 7, 8)."""
    out = np.empty((len(volts), 7, 8))
    for row, v in zip(out, volts, strict=True):
        engine.substep(v)
        engine.measure(row)
    return out


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("environment", ["ground", "suspended"])
def test_reset_stands_at_rest(backend, environment):
    engine = ENGINES[backend](environment=environment)
    run(engine, wave(60.0, 30.0, PERIOD))
    engine.reset(seed=3)
    at_rest = sample(engine)
    assert (engine.backend, engine.engine, engine.environment) == (backend, "mujoco", environment)
    assert np.isfinite(at_rest).all()
    assert np.abs(at_rest[POSITION]).max() < 1e-2, "the published fit's rest differs by 0.4 degrees"
    assert np.abs(at_rest[[VELOCITY, DEFLECTION_RATE, TORQUE, FORCE]]).max() < 1e-12
    expected = np.zeros(13)
    expected[2] = 12.54e-3 if environment == "ground" else 2 * 12.54e-3
    expected[6] = 1.0
    assert base(engine) == pytest.approx(expected, abs=1e-9)
    assert engine.counters()["stops_hit"] == 0


@pytest.mark.parametrize("backend", BACKENDS)
def test_same_voltages_same_trajectory_whatever_is_read_in_between(backend):
    volts = wave(60.0, 30.0, 2 * PERIOD)
    first, second = ENGINES[backend](), ENGINES[backend]()
    once = run(first, volts)
    for v in volts:
        second.substep(v)
    assert np.array_equal(sample(second), once[-1])
    second.reset()
    out = np.empty(13)
    for v in volts:
        second.base(out)
        second.counters()
        second.substep(v)
    assert np.array_equal(sample(second), once[-1])


@pytest.mark.parametrize("backend", BACKENDS)
def test_rows_are_consistent_derivatives(backend):
    """Rates are differences of positions; the acceleration is the velocity's change over the substep."""
    engine = ENGINES[backend](environment="suspended")
    rows = run(engine, wave(60.0, 30.0, 4 * PERIOD))
    for value, rate in ((POSITION, VELOCITY), (DEFLECTION, DEFLECTION_RATE)):
        step = np.diff(rows[:, value], axis=0)
        assert step / STEP_S == pytest.approx(rows[1:, rate], abs=2e-3 * np.abs(rows[:, rate]).max())
    change = np.diff(rows[:, VELOCITY], axis=0) / STEP_S
    assert change == pytest.approx(rows[1:, ACCELERATION], abs=2e-2 * np.abs(change).max()), "MuJoCo steps dampers implicitly"


@pytest.mark.parametrize("backend", BACKENDS)
def test_hip_torque_and_tip_force_have_the_same_power(backend):
    engine = ENGINES[backend](environment="suspended")
    rows = run(engine, wave(80.0, 30.0, 10 * PERIOD))
    by_hip = (rows[:, TORQUE] * rows[:, VELOCITY]).reshape(-1, 4, 2).sum(axis=2)
    by_tip = (rows[:, FORCE] * rows[:, DEFLECTION_RATE]).reshape(-1, 4, 2).sum(axis=2)
    assert by_hip == pytest.approx(by_tip, abs=2e-3 * np.abs(by_tip).max()), "loops are closed to that at velocity level"


@pytest.mark.parametrize("backend", BACKENDS)
def test_voltage_above_neutral_turns_hips_by_torque_sign(backend):
    engine = ENGINES[backend](environment="suspended")
    for i, joint in enumerate(JOINTS):
        engine.reset()
        volts = np.full(8, 112.5)
        volts[i] += 40.0
        rows = run(engine, np.tile(volts, (PERIOD // 4, 1)))
        assert np.sign(rows[-1, TORQUE, i]) == torque_sign(joint) == np.sign(rows[-1, VELOCITY, i])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("environment", "tolerance"), [("suspended", 1e-9), ("ground", 1e-3)])
def test_left_mirrors_right(backend, environment, tolerance):
    """Mirrored voltages about the sagittal plane give mirrored motion, also of the base. Impacts amplify rounding."""
    engine = ENGINES[backend](environment=environment)
    swap = [4, 5, 6, 7, 0, 1, 2, 3]
    volts = wave(60.0, 30.0, PERIOD)
    mirrored = 112.5 - (volts - 112.5)[:, swap]
    one = run(engine, volts)[:, :2] * ANGLE_SIGN
    base_one = base(engine)
    engine.reset()
    other = run(engine, mirrored)[:, :2] * ANGLE_SIGN
    assert other[:, :, swap] == pytest.approx(one, abs=tolerance * np.abs(one).max())
    flip = np.array([1, -1, 1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1])  # position, quaternion xyzw, v, omega
    assert base(engine) == pytest.approx(flip * base_one, abs=tolerance)


def test_base_velocity_is_in_base_link(rng):
    """A thrown robot: velocities in its own axes, from differences of position and attitude."""
    engine = ENGINES["full"](gravity=0.0)
    data = engine.data
    turn = rng.normal(size=4)
    data.qpos[2], data.qpos[3:7] = 100.0, turn / np.linalg.norm(turn)
    data.qvel[:3], data.qvel[3:6] = rng.normal(0.0, 0.2, 3), rng.normal(0.0, 0.05, 3)
    mujoco.mj_forward(engine.model, data)
    before = base(engine)
    rotation = data.body("base_link").xmat.reshape(3, 3).copy()
    engine.substep(np.full(8, 112.5))
    after = base(engine)
    middle = (before + after) / 2
    assert rotation.T @ (after[:3] - before[:3]) / STEP_S == pytest.approx(middle[7:10], abs=2e-3)
    step = rotation.T @ data.body("base_link").xmat.reshape(3, 3)
    assert np.array([step[2, 1], step[0, 2], step[1, 0]]) / STEP_S == pytest.approx(middle[10:13], rel=1e-2, abs=0.5)


def test_loops_stay_closed_over_a_trot():
    engine = ENGINES["full"]()
    worst = 0.0
    for v in wave(80.0, 20.0, 50 * PERIOD):  # 0.2 s
        engine.substep(v)
        worst = max(worst, engine.counters()["constraint_residual"])
    assert worst < 1e-3, "mm; the links are 2 to 8 mm long"
    assert engine.counters()["finite"] == 1
    assert base(engine)[2] > 8e-3


def test_feet_neither_sink_nor_get_pulled():
    engine = ENGINES["full"]()
    deepest, pull = 0.0, 0.0
    wrench = np.empty(6)
    for v in wave(80.0, 20.0, 25 * PERIOD):
        engine.substep(v)
        for i in range(engine.data.ncon):
            mujoco.mj_contactForce(engine.model, engine.data, i, wrench)
            deepest, pull = min(deepest, engine.data.contact[i].dist), min(pull, wrench[0])
            assert np.hypot(wrench[1], wrench[2]) <= 0.51 * wrench[0] * (1 + 1e-6) + 1e-9
    assert -0.1 < deepest < 0.0, "mm: blows on a spring of 2 N/mm"
    assert pull >= 0.0


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("hz", [10.0, 85.0, 122.0])
def test_full_voltage_square_waves_meet_the_stops_and_stay_finite(backend, hz):
    engine = ENGINES[backend](environment="suspended")
    volts = np.where(np.sin(2e-3 * np.pi * hz * 50e-3 * np.arange(60 * PERIOD)) >= 0, 225.0, 0.0)
    rows = run(engine, 112.5 + (volts - 112.5)[:, None] * DRIVE_SIGN)
    counters = engine.counters()
    assert np.isfinite(rows).all()
    assert counters["finite"] == 1
    assert np.abs(rows[:, POSITION]).max() < 1.0, "no crank passes its dead centre"
    if backend == "full":
        assert (counters["stops_hit"] > 0) == (np.abs(rows[:, DEFLECTION]).max() > 0.3e-3)
        assert np.abs(rows[:, DEFLECTION]).max() < 0.4e-3
        assert counters["constraint_residual"] < 0.05


def test_resonant_square_wave_meets_the_stops():
    engine = ENGINES["full"](environment="suspended")
    volts = np.where(np.sin(2e-3 * np.pi * 85.0 * 50e-3 * np.arange(20 * PERIOD)) >= 0, 225.0, 0.0)
    run(engine, 112.5 + (volts - 112.5)[:, None] * DRIVE_SIGN)
    assert engine.counters()["stops_hit"] > 0
    engine.reset()
    assert engine.counters()["stops_hit"] == 0


@given(
    x=st.floats(-2, 2), rate=st.floats(-50, 50), low=st.floats(-1, -0.1), high=st.floats(0.1, 1),
    stiffness=st.floats(0, 50), damping=st.floats(0, 10),
)  # fmt: skip
def test_stop_never_pulls(x, rate, low, high, stiffness, damping):
    force = stop_force(x, rate, low, high, stiffness, damping)
    if low <= x <= high:
        assert force == 0.0
    elif x > high:
        assert force == -max(stiffness * (x - high) + damping * rate, 0.0)
    else:
        assert force == -stop_force(-x, -rate, -high, -low, stiffness, damping) >= 0.0


@pytest.mark.parametrize("backend", BACKENDS)
def test_compiled_loop_is_the_engine(backend):
    engine, raw = ENGINES[backend](), ENGINES[backend]()
    compiled_step_loop()(raw.model._address, raw.data._address, PERIOD)
    for _ in range(PERIOD):
        engine.substep(np.full(8, 112.5))
    assert np.array_equal(engine.data.qpos, raw.data.qpos)
    assert raw.data.time == pytest.approx(PERIOD * 50e-3)
