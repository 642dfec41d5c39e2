"""The tracer keeps the meaning of what it records: folded, shared and emitted expressions equal plain arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from interpreter import evaluate

from hamr_dynamics import layout, scalar
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.chassis_stages import balance_free, balance_soft, predict
from hamr_dynamics.emit import Stage, loop_body, loop_source
from hamr_dynamics.leg_stages import observe, servo, suspended
from hamr_dynamics.plant import flatten, plant
from hamr_dynamics.step import LegState, reach_leg, step_suspended
from hamr_dynamics.trace import Graph, Var
from hamr_dynamics.walking_leg_stages import finish_legs, grounded, reach

STEP = 0.05
WHOLE = 2**50  # up to here floats hold whole numbers exactly
OPERATIONS = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "neg": lambda a, b: -a,
    "max": scalar.maximum, "min": scalar.minimum, "positive": lambda a, b: scalar.positive(a),
    "abs": lambda a, b: abs(a), "cube": lambda a, b: a**3,
}  # fmt: skip

number = st.integers(-3, 3)
line = st.tuples(st.sampled_from(sorted(OPERATIONS)), st.integers(0, 40), st.integers(0, 40))


def run(program, inputs, constants):
    """All values of a program: each line applies an operation to two of the values before it."""
    values = [*inputs, *map(float, constants)]
    for op, i, j in program:
        values.append(OPERATIONS[op](values[i % len(values)], values[j % len(values)]))
    return values


@given(st.lists(line, min_size=1, max_size=25), st.lists(number, min_size=3, max_size=3), st.lists(number, min_size=3, max_size=3))
def test_any_program_of_whole_numbers_is_traced_exactly(program, inputs, constants):
    expected = run(program, [float(x) for x in inputs], constants)
    assume(max(abs(x) for x in expected) < WHOLE)
    stage = Stage("program", {"x": ("0", "1", "2")}, {"y": tuple(map(str, range(len(expected))))})
    stage.write("y", "0", 0.0)
    for i, value in enumerate(run(program, [stage.read("x", str(i)) for i in range(3)], constants)):
        stage.write("y", str(i), value if isinstance(value, Var) else float(value))
    x = np.array(inputs, float)
    assert evaluate(stage, {"x": x[:, None]})["y"][:, 0].tolist() == expected
    exec(loop_source(stage, 1), scope := {"over_lanes": as_python})
    scope["program"](x, y := np.zeros(len(expected)))
    assert y.tolist() == expected


def as_python(arrays: str, text: str) -> Callable[..., None]:
    """What `over_lanes` makes of a text, in plain Python."""
    choices = {"larger": lambda a, b: a if a > b else b, "smaller": lambda a, b: a if a < b else b, "gate": lambda a: float(a > 0.0)}
    scope = {"U": int, "sqrt": math.sqrt, "floor": math.floor, "real": float} | choices
    return lambda *given: exec(text, scope | dict(zip(arrays.split(", "), given, strict=True)))


def test_a_row_that_stays_is_not_written():
    """An output that lies on the input that it is."""
    stage = Stage("rows", {"x": ("0", "1")}, {"new_x": ("0", "1")})
    first, second = (stage.read("x", row) for row in "01")
    stage.write("new_x", "0", first)
    stage.write("new_x", "1", second + first)
    body = loop_body(stage, 1, work={"x": 0, "new_x": 0})
    work = np.array([2.0, 3.0])
    as_python("work", body)(work)
    assert work.tolist() == [2.0, 5.0]
    assert body.count("] = ") == 1


@given(st.floats(0.1, 10), st.floats(-10, 10))
def test_division_and_root_are_traced(a, b):
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    stage = Stage("f", {"in": ("x", "y")}, {"out": ("value",)}, graph)
    x, y = stage.read("in", "x"), stage.read("in", "y")
    stage.write("out", "value", scalar.sqrt(x) / (1.0 + y * y) + y / 3.0)
    out = evaluate(stage, {"in": np.array([[a], [b]])})["out"][0, 0]
    assert out == pytest.approx(math.sqrt(a) / (1 + b * b) + b / 3, rel=1e-14, abs=1e-14)


def test_equal_expressions_are_recorded_once():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    assert (x * y + 1.0).index == (1.0 + y * x).index
    assert graph.input("x").index == x.index
    assert isinstance(x - x, float)
    assert isinstance(x * 0.0, float)
    with pytest.raises(TypeError, match="no truth value"):
        bool(x)


def stage_inputs(stage: Stage, rng, lanes: int) -> dict[str, np.ndarray]:
    """Inputs of the size that the robot's have; parameters as they are."""
    found = {}
    for array, names in stage.inputs.items():
        found[array] = rng.normal(0.0, 0.1, (len(names), lanes))
        for name in ("quaternion.0", "mass", "fl.height"):
            if name in names:
                found[array][names.index(name)] += 1.0
    return found


def real_parameters(backend: str, leg: str, **ground: float) -> np.ndarray:
    robot = plant(backend)
    flat = {**flatten(robot.parameters(leg)), **ground}
    return np.array([flat[name] for name in layout.parameter_rows(robot)])


GROUND = {"friction": 0.51, "contact_stiffness": 2.0, "contact_damping": 0.5, "slip_speed": 1e-3, "gravity": 9.81e-3}


@pytest.mark.parametrize("backend", ["simple", "simple_published", "full"])
@pytest.mark.parametrize("leg", ["fl", "rl"])
def test_traced_leg_step_is_the_function_on_plain_numbers(backend, leg):
    robot, rng = plant(backend), np.random.default_rng(1)
    stage = suspended(robot, STEP)
    for _ in range(5):
        q, v, a, drive = rng.uniform(-0.4, 0.4, 2), rng.normal(0, 0.1, 2), rng.normal(0, 0.1, 2), rng.uniform(-112, 112, 2)
        state = LegState(tuple(q), tuple(v), tuple(a))
        truth, _ = step_suspended(robot.leg, state, tuple(drive), robot.parameters(leg), GROUND["gravity"], STEP)
        arrays = {"state": np.array([*q, *v, *a, 0, 0]), "drive": drive, "param": real_parameters(backend, leg, **GROUND)}
        new = evaluate(stage, {name: x[:, None] for name, x in arrays.items()})["new_state"][:6, 0]
        assert new == pytest.approx(np.array([*truth.q, *truth.v, *truth.a], float), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("backend", ["simple", "full"])
def test_traced_elimination_is_the_function_on_plain_numbers(backend):
    """The largest stage, with the foot in and out of the ground."""
    robot, rng = plant(backend), np.random.default_rng(2)
    stage = reach(robot, STEP)
    for height in (12.4, 12.8):
        q, v, drive, near = rng.uniform(-0.2, 0.2, 2), rng.normal(0, 0.1, 2), rng.uniform(-112, 112, 2), rng.normal(0, 0.05, 13)
        near[9:12], near[12] = (0.0, 0.6, 0.8), height
        base = {name: tuple(near[i : i + 3]) for name, i in (("omega", 0), ("omega_mid", 3), ("velocity", 6), ("normal", 9))}
        base |= {"height": height, "gravity": GROUND["gravity"]}
        ground = {name.removeprefix("contact_"): x for name, x in GROUND.items()}
        r = reach_leg(robot.leg, LegState(tuple(q), tuple(v), (0.0, 0.0)), tuple(drive), robot.parameters("fl"), base, ground, STEP)
        arrays = {"state": np.array([*q, *v, 0, 0, 0, 0]), "drive": drive, "param": real_parameters(backend, "fl", **GROUND), "near": near}
        found = evaluate(stage, {name: x[:, None] for name, x in arrays.items()})["reach"][:, 0]
        for name in ("soft_matrix", "soft_rhs", "free_matrix", "free_rhs", "soft_own", "free_own", "solve", "point"):
            truth = np.array(getattr(r, name), float)
            rows = [layout.REACH.index(f"{name}.{i}") for i in range(len(truth))]
            assert found[rows] == pytest.approx(truth, rel=1e-13, abs=1e-13 * np.abs(truth).max()), name


@pytest.mark.parametrize("environment", ["ground", "suspended"])
def test_emitted_source_is_the_trace(environment):
    """Every stage's source, run as plain Python in one work array with outputs on inputs, gives the trace's values exactly."""
    robot, rng, lanes = plant("simple"), np.random.default_rng(3), 2
    chain = {"suspended": [suspended(robot, STEP)]}
    chain["ground"] = [
        predict(STEP), reach(robot, STEP), balance_soft(STEP), grounded(robot, STEP),
        balance_free(STEP), finish_legs(STEP), servo(112.5), observe(robot, STEP),
    ]  # fmt: skip
    for stage in chain[environment]:
        arrays, places, end = stage_inputs(stage, rng, lanes), {}, 0
        renewed = {new: old for new, (old, first) in layout.renewed(robot).items() if first == 0}
        for name, rows in (stage.inputs | stage.outputs).items():
            places[name] = places[renewed[name]] if renewed.get(name) in places else end
            end = max(end, places[name] + len(rows) * lanes)
        work = np.zeros(end)
        for name, x in arrays.items():
            work[places[name] : places[name] + x.size] = x.ravel()
        with np.errstate(all="ignore"):
            as_python("work", loop_body(stage, lanes, work=places))(work)
            for name, truth in evaluate(stage, arrays).items():
                assert np.array_equal(work[places[name] : places[name] + truth.size], truth.ravel(), equal_nan=True), (stage.name, name)


def test_parameters_that_differ_between_legs_are_lanes():
    """A kernel compiles in what all legs share; whatever differs must be an array row, or a rear leg would run as a front one."""
    for backend in ("simple", "simple_published", "full"):
        robot = plant(backend)
        legs = [flatten(robot.parameters(leg)) for leg in ("fl", "rl", "fr", "rr")]
        different = {name for name in legs[0] if len({leg[name] for leg in legs}) > 1}
        assert different
        assert different <= set(BatchSim(robot, 1, block=1, environment="suspended").parameter_names)
