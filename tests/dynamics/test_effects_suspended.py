"""The bank of effects in the whole robot, held up: the same trajectories as one leg's machine gives, and none when it is off."""

from __future__ import annotations

import numpy as np
import pytest
from interpreter import evaluate

from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import driver, layout, leg_stages, machine_kernel
from hamr_dynamics.bank_stages import LEG_BANK, USUAL
from hamr_dynamics.batch import DRIVE_SIGN, SIGN, BatchSim
from hamr_dynamics.effects.bank import Bank
from hamr_dynamics.effects.effects_file import Change, EffectsFile, PlacedEffect
from hamr_dynamics.engine import KernelEngine
from hamr_dynamics.machine import leg_machine
from hamr_dynamics.plant import plant, with_effects
from hamr_dynamics.step_parts import step_parts

NEUTRAL = value("actuator.neutral_voltage")
STEPS = 2000  # 100 ms
FORMS = Bank(2).forms
SIMPLE = plant("simple")


def several(*joints: str) -> EffectsFile:
    """Effects of all kinds at joints."""
    effects = (
        PlacedEffect("coulomb_friction", "presliding", joints, {"level": 8e-6, "distance": 0.005}),
        PlacedEffect("piezo_hysteresis", "plays", joints, {**{f"weight{i}": 0.05 for i in (1, 2, 3, 4)}, "width": 20.0}),
        PlacedEffect("configuration_dependent_stiffness", "potential", joints,
                     {f"c{i}": 1e-3 for i in ("11", "30", "21", "12", "03", "40", "31", "22", "13", "04")}),
        PlacedEffect("sensor_latency", "pade", joints, {"delay": 2e-4}),
        PlacedEffect("backlash", "dead_band", joints, {"play": 0.01, "share": 0.6}),
    )  # fmt: skip
    return EffectsFile(effects, (Change("gain", joints, 0.1), Change("stiffness", joints, 1e-5)))


def simulator(n: int, effects: EffectsFile | None = None) -> BatchSim:
    """Blocks of one robot: one compiled kernel serves all tests here, and the nodes."""
    return BatchSim(with_effects(SIMPLE), n, environment="suspended", block=1, effects=effects)


@pytest.fixture(scope="module")
def runs() -> dict:
    """(form -> largest differences between robot and machine, largest effect), 100 ms of noise, every form three times its usual size."""
    machine = leg_machine(SIMPLE, "fl", gravity=value("robot.gravity"))
    drives = np.random.default_rng(0).normal(0, 40, (STEPS, 2)).clip(-112, 112)
    rows = np.tile(machine.neutral(USUAL), (len(FORMS) + 1, 1))
    sim = simulator(len(FORMS))
    for i, (name, form) in enumerate(FORMS):
        for parameter in form.sizes:
            for place in machine.places(form):
                row = f"{name}.{form.name}.{parameter.name}.{place}"
                rows[i, machine.parameter_rows.index(row)] = size = 3 * parameter.typical * USUAL.of(parameter.dimension)
                lanes = sim.parameter(row)
                lanes[i, 0] = size
                sim.set_parameter(row, lanes)
    expected = machine_kernel.simulate(machine, drives, rows, step=SERVO_MS, substeps=1)
    found, volts = np.empty((len(FORMS), STEPS, 4)), np.full((len(FORMS), 1, 8), NEUTRAL)
    for k in range(STEPS):
        found[:, k, :2], found[:, k, 2:] = sim.measured()[0][:, :2], sim.observe(volts[:, 0])["tip"][:, :2]
        volts[:, 0, :2] = NEUTRAL + drives[k]
        sim.step_voltages(volts)
    difference, effect = np.abs(found - expected[:-1]).max((1, 2)), np.abs(expected[:-1] - expected[-1]).max((1, 2))
    return {(name, form.name): (difference[i], effect[i]) for i, (name, form) in enumerate(FORMS)}


@pytest.mark.parametrize("key", [(name, form.name) for name, form in FORMS], ids=".".join)
def test_robot_and_machine_agree(runs, key):
    """One implementation: hip angles (as measured) and actuator tips to 1e-12 over 100 ms."""
    difference, effect = runs[key]
    assert difference < 1e-12
    assert effect > 1e-5 or key == ("end_stop", "upper")  # a stop beyond this motion


def test_robot_and_machine_agree_on_several_at_once():
    """Laws act one after the other in the same order."""
    machine, sim = leg_machine(SIMPLE, "fl", gravity=value("robot.gravity")), simulator(1, several("all"))
    rows = np.array([[sim.parameter(row)[0, 0] for row in machine.parameter_rows[:-1]] + [SERVO_MS]])
    drives = np.random.default_rng(1).normal(0, 40, (400, 2)).clip(-112, 112)
    expected, found = machine_kernel.simulate(machine, drives, rows, step=SERVO_MS, substeps=1)[0, :, :2], np.empty((400, 2))
    for k, drive in enumerate(drives):
        found[k] = sim.measured()[0][0, :2]
        sim.step_voltages(NEUTRAL + np.tile(drive, 4)[None, None] * DRIVE_SIGN)
    assert np.abs(found - expected).max() < 1e-12
    assert np.abs(found).max() > 0.05


def trace(model, environment: str, n: int, steps: int) -> np.ndarray:
    """State rows of the legs and the base after steps under noise, from the traces in plain arithmetic: no sum is contracted."""
    h, legs, rng = SERVO_MS, 4 * n, np.random.default_rng(3)
    sim = BatchSim.__new__(BatchSim)  # its parameters alone: no kernel is compiled
    sim.plant, sim.n, sim.block, sim._blocks, sim.environment, sim.dtype = model, n, n, 1, environment, np.dtype(float)
    sim.parameter_names, sim.body_names = layout.parameter_rows(model), layout.body_rows(model)
    sim._param, sim._body = sim._zeros(sim.parameter_names, 4), sim._zeros(sim.body_names, 1)
    sim._fill_parameters(None, value("robot.gravity"))
    state = np.zeros((len(layout.state_rows(model)), legs))
    state[:4] = rng.normal(0, 0.05, (4, legs))
    base = np.zeros((len(layout.BASE), n))
    base[2], base[3], base[7:13] = 6.0 + rng.normal(0, 3, n), 1.0, rng.normal(0, 0.02, (6, n))
    arrays = {"state": state, "base": base, "param": sim._param.reshape(-1, legs), "body": sim._body.reshape(-1, n)}
    chain = [(part, 4) for part in (*leg_stages.sense(model, h), *leg_stages.command(model, h))] + step_parts(model, environment, h)
    for _ in range(steps):
        arrays["drive"] = rng.normal(0, 40, (2, legs))
        for part, lanes in chain:
            stage = part.stage
            inputs = {name: arrays[name].reshape(-1, lanes * n)[: len(rows)] for name, rows in stage.inputs.items()}
            with np.errstate(divide="ignore", invalid="ignore"):
                found = evaluate(stage, inputs)
            for name, values in found.items():
                if not len(stage.outputs[name]):
                    continue
                old, first = ("state", part.memory) if name == "memory" else layout.renewed(model).get(name, (name, 0))
                if old == name:
                    arrays[name] = values.reshape(-1, n if name in ("pose", "base") else legs)
                else:
                    arrays[old][first : first + len(values)] = values
            if stage.name == "command":
                arrays["drive"] = arrays["state"][len(layout.STATE) : len(layout.STATE) + 2]
            if stage.name == "sensed":
                assert np.array_equal(arrays["measured"], arrays["state"][:4])
    return np.concatenate([arrays["state"][: len(layout.STATE)].ravel(), arrays["base"].ravel()])


@pytest.mark.parametrize("environment", ["suspended", "ground"])
@pytest.mark.parametrize("backend", ["simple", "full"])
def test_an_idle_bank_changes_no_bit(backend, environment):
    """Of the step as it is written. Compiled, multiplications and sums may contract elsewhere: some 1e-15, see below."""
    plain = trace(plant(backend), environment, 3, 5)
    assert np.array_equal(trace(with_effects(plant(backend)), environment, 3, 5), plain)
    assert np.abs(plain).max() > 1.0


def test_an_idle_bank_in_the_kernel(rng):
    plain, idle = BatchSim(SIMPLE, 2, environment="suspended", block=1), simulator(2)
    for sim in (plain, idle):
        sim.step_voltages(np.random.default_rng(4).uniform(0, 225, (2, 400, 8)))
    assert np.abs(plain.q - idle.q).max() < 1e-14
    shaped = simulator(2)  # shapes of effects that are off do nothing at all
    for name, form in FORMS:
        for shape in form.shapes:
            for place in LEG_BANK.places(form):
                shaped.set_parameter(f"{name}.{form.name}.{shape.name}.{place}", rng.uniform(0.1, 3.0, (2, 4)))
    shaped.step_voltages(np.random.default_rng(4).uniform(0, 225, (2, 400, 8)))
    assert np.array_equal(shaped.q, idle.q)
    assert np.array_equal(shaped.qd, idle.qd)


def test_no_effects_no_bank():
    """An empty file runs the plain kernel, whose source knows nothing of effects."""
    assert BatchSim(SIMPLE, 1, environment="suspended", effects=EffectsFile()).plant is SIMPLE
    source = driver.source(SIMPLE, "ground", 1, "float64", SERVO_MS, NEUTRAL)
    assert "coulomb" not in source
    assert layout.state_rows(SIMPLE) == layout.STATE


def test_equal_numbers_are_a_symmetric_robot(rng):
    """Left and right run as mirror images, to the last bit, with effects of all kinds everywhere."""
    sim = simulator(1, several("all"))
    drive = np.tile(rng.integers(-110, 110, (1, 400, 2)), (1, 1, 4)) * DRIVE_SIGN  # whole volts: neutral plus and minus them are exact
    sim.step_voltages(NEUTRAL + drive)
    legs = dict(zip(LEGS, np.concatenate([sim.q, sim.qd, sim.measured()[0]]).reshape(3, 4, 2).transpose(1, 0, 2), strict=True))
    signs = dict(zip(LEGS, SIGN.reshape(4, 2), strict=True))
    for left, right in (("fl", "fr"), ("rl", "rr")):
        assert np.array_equal(legs[left] * signs[left], legs[right] * signs[right])
    assert np.abs(legs["fl"][0] - legs["fl"][2]).max() > 1e-4  # the sensors are late


def test_effects_stay_where_they_are_put(rng):
    volts = rng.uniform(0, 225, (1, 400, 8))
    whole, part = simulator(1), simulator(1, several("rr"))
    for sim in (whole, part):
        sim.step_voltages(volts)
    assert np.array_equal(part.q[:, :6], whole.q[:, :6])
    assert np.abs(part.q[:, 6:] - whole.q[:, 6:]).max() > 1e-3


def test_a_reset_forgets(rng):
    """All that effects remember; and only of the robots that are reset."""
    volts = rng.uniform(0, 225, (2, 400, 8))
    sim, fresh = simulator(2, several("all")), simulator(2, several("all"))
    sim.step_voltages(volts)
    before = sim.q
    sim.reset(np.array([False, True]))
    assert np.array_equal(sim.q[0], before[0])
    sim.step_voltages(volts)
    fresh.step_voltages(volts)
    assert np.array_equal(sim.q[1], fresh.q[1])
    assert not np.array_equal(sim.q[0], fresh.q[0])


def test_the_engine_reports_what_sensors_say(rng):
    """The sample holds measured angles and rates, tips with the actuators' slip, and the drive as it acted; measuring changes nothing."""
    engine, sim = KernelEngine(SIMPLE, environment="suspended", effects=several("all")), simulator(1, several("all"))
    sample, angles = np.zeros((7, 8)), []
    for volts in rng.uniform(0, 225, (200, 8)):
        engine.measure(sample)
        engine.measure(sample)
        angles.append(sample[0].copy())
        assert np.array_equal(sample[0], sim.measured()[0][0])
        engine.substep(volts)
        sim.step_voltages(volts[None, None])
    assert np.array_equal(engine.sim.q, sim.q)
    rate = np.diff(angles, axis=0)[-1] / (SERVO_MS * 1e-3)  # of the measured angle, half a step before the last sample
    assert np.abs(rate - sample[1]).max() < 0.05 * np.abs(sample[1]).max()
    engine.reset()
    engine.measure(sample)
    assert np.array_equal(sample[:6], np.zeros((6, 8)))


def test_the_leg_law_sees_the_sensors():
    """In closed loop a late sensor changes the motion; in open loop it does not."""
    late = EffectsFile((PlacedEffect("sensor_latency", "pade", ("all",), {"delay": 5e-4}),))
    targets = np.full((1, 8), 0.2)
    exact, delayed = simulator(1), simulator(1, late)
    for sim in (exact, delayed):
        sim.step_targets(targets)
    assert np.abs(exact.q - delayed.q).max() > 1e-3
    volts = np.full((1, 80, 8), 150.0)
    exact, delayed = simulator(1), simulator(1, late)
    for sim in (exact, delayed):
        sim.step_voltages(volts)
    assert np.array_equal(exact.q, delayed.q)
