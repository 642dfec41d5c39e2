"""Compiled kernels compute what the traces say, the same in every lane, block size and precision, and the same bits on every start."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from interpreter import Interpreter

from hamr_dynamics import kernels, layout
from hamr_dynamics.batch import BLOCK, SIGN, BatchSim
from hamr_dynamics.engine import KernelEngine

CASES = [(backend, environment) for backend in ("simple", "full") for environment in ("ground", "suspended")]
cases = pytest.mark.parametrize(("backend", "environment"), CASES)


def scattered(backend: str, environment: str, n: int, **options) -> BatchSim:
    """Robots that have run apart for a period: in motion, feet in and out of contact."""
    sim = BatchSim(backend, n, environment=environment, **options)
    sim.step_targets(0.25 * np.sin(np.arange(8.0 * n)).reshape(n, 8))
    return sim


def everything(sim: BatchSim) -> np.ndarray:
    """(n, 29) positions and rates of robots."""
    return np.hstack([sim.q, sim.qd, sim.position, sim.quaternion, sim.velocity, sim.angular_velocity])


@cases
def test_kernel_computes_the_trace(backend, environment, rng):
    sim = scattered(backend, environment, BLOCK["float64"])
    truth = Interpreter(sim)
    volts = rng.uniform(0, 225, (sim.n, 3, 8))
    for k in range(3):
        truth.step(volts[:, k])
    sim.step_voltages(volts)
    assert truth.leg_rows("state", layout.STATE, "q", 2).reshape(-1, 8) * SIGN == pytest.approx(sim.q, abs=1e-13)
    assert truth.leg_rows("state", layout.STATE, "v", 2).reshape(-1, 8) * SIGN == pytest.approx(sim.qd, abs=1e-12)
    if environment == "ground":
        assert truth.base_rows("position", 3) == pytest.approx(sim.position, abs=1e-12)
        assert truth.base_rows("velocity", 3) == pytest.approx(sim.velocity, abs=1e-12)


@cases
def test_a_robot_runs_the_same_in_any_lane(backend, environment, rng):
    """Bit for bit, whatever its neighbours do, also in a block that is not full."""
    n = 2 * BLOCK["float64"] + 3
    sim, other = (BatchSim(backend, n, environment=environment) for _ in range(2))
    volts = rng.uniform(0, 225, (n, 80, 8))
    order = rng.permutation(n)
    sim.step_voltages(volts)
    other.step_voltages(volts[order])
    assert np.array_equal(everything(sim)[order], everything(other))
    twins = BatchSim(backend, n, environment=environment)
    twins.step_voltages(np.broadcast_to(volts[:1], volts.shape))
    assert np.array_equal(everything(twins), np.broadcast_to(everything(sim)[:1], (n, everything(sim).shape[1])))


@cases
def test_batch_agrees_with_the_one_robot_kernel(backend, environment):
    """To 1e-12 over one period under the leg law, the kernel behind the topics."""
    batch, one = BatchSim(backend, 2, environment=environment, block=BLOCK["float64"]), BatchSim(backend, 1, environment=environment)
    assert one.block == 1
    targets = 0.2 * np.sin(np.arange(16.0)).reshape(2, 8)
    batch.step_targets(targets)
    one.step_targets(targets[:1])
    assert np.abs(everything(batch)[:1] - everything(one)).max() < 1e-12


@cases
def test_one_call_of_many_steps_is_many_calls_of_one(backend, environment, rng):
    volts = rng.uniform(0, 225, (1, 80, 8))
    whole, parts = (BatchSim(backend, 1, environment=environment) for _ in range(2))
    whole.step_voltages(volts)
    engine = KernelEngine(backend, environment=environment)
    for k in range(80):
        parts.step_voltages(volts[:, k : k + 1])
        engine.substep(volts[0, k])
    assert np.array_equal(everything(whole), everything(parts))
    assert np.array_equal(everything(whole), everything(engine.sim))


@pytest.mark.parametrize(("backend", "environment"), [("simple", "ground"), ("full", "ground")])
def test_single_precision_is_close(backend, environment):
    """Over a period of free motion; once feet strike the ground, differences grow as contact makes them."""
    targets = 0.2 * np.sin(np.arange(8.0 * 32)).reshape(32, 8)
    double, single = (BatchSim(backend, 32, environment=environment, dtype=dtype) for dtype in (np.float64, np.float32))
    for sim in (double, single):
        sim.set_state(position=(0.0, 0.0, 20.0))
        sim.step_targets(targets)
    assert np.abs(single.q - double.q).max() < 2e-5
    assert np.abs(single.position - double.position).max() < 2e-5 * 20


def test_records_are_what_was_run(rng):
    """`record` gives the state before each step and the voltage held over it; the law is the controller's."""
    sim = BatchSim("simple", 3, environment="suspended")
    targets = rng.uniform(-0.2, 0.2, (3, 8))
    record = sim.step_targets(targets, record=True)
    assert np.array_equal(record["q"][:, 0], np.zeros((3, 8)))
    again = BatchSim("simple", 3, environment="suspended")
    again.step_voltages(record["volts"])
    assert np.abs(everything(again) - everything(sim)).max() < 1e-14
    assert record["volts"].min() >= 0.0
    assert record["volts"].max() <= 225.0


FRESH = """
import sys, numpy as np
from hamr_dynamics.batch import BatchSim
sim = BatchSim("simple", 32, environment="suspended", dtype=np.float32)
for k in range(20):
    sim.step_targets(0.3 * np.sin(k + np.arange(256.0)).reshape(32, 8))
sys.stdout.write(sim.q.tobytes().hex() + sim.qd.tobytes().hex())
"""


def test_first_start_and_later_starts_give_the_same_bits(tmp_path, monkeypatch):
    """The process that compiles and one that finds machine code on disk run the same instructions."""
    monkeypatch.setenv("HAMR_CACHE", str(tmp_path))
    outputs = [subprocess.run([sys.executable, "-c", FRESH], capture_output=True, check=True, text=True).stdout for _ in range(2)]
    assert list(tmp_path.glob("kernels/*.py"))
    assert outputs[0]
    assert outputs[0] == outputs[1]


def test_another_compiler_finds_no_stale_code(tmp_path, monkeypatch):
    monkeypatch.setenv("HAMR_CACHE", str(tmp_path))
    first, again = (kernels.load_source("text", "answer = 42\n") for _ in range(2))
    monkeypatch.setattr(kernels, "_compiler", lambda: b"another")
    assert first is again
    assert kernels.load_source("text", "answer = 42\n").__file__ != first.__file__
