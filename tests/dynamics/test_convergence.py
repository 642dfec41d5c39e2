"""The step is second order: half the step, a quarter of the error, in smooth motion on a fixed chassis and in flight."""

from __future__ import annotations

import numpy as np
import pytest
from interpreter import Interpreter, Seen
from mechanics import motion, undamped

from hamr_dynamics import layout
from hamr_dynamics.batch import BatchSim

SPAN = 4.0  # ms
NEUTRAL, SWING, PER_MS = 112.5, 20.0, 0.1  # V, V, and 100 Hz: near resonance but clear of the stops


def final(backend: str, environment: str, h: float) -> np.ndarray:
    """Everything about the robot after SPAN under smooth voltages, in steps of h."""
    rng = np.random.default_rng(0)
    sim = BatchSim(backend, 1, environment=environment)
    sim.set_state(q=rng.uniform(-0.2, 0.2, 8), qd=rng.normal(0, 0.02, 8))
    if environment == "ground":
        turn = rng.normal(size=4)
        sim.set_state(
            position=(0.0, 0.0, 1e3), quaternion=turn / np.linalg.norm(turn), velocity=rng.normal(0, 0.1, 3),
            angular_velocity=rng.normal(0, 0.03, 3),
        )  # fmt: skip
    robot = Interpreter(sim, h)
    for k in range(round(SPAN / h)):
        robot.step(NEUTRAL + SWING * np.sin(2 * np.pi * PER_MS * (k + 0.5) * h + np.arange(8.0))[None])
    hips = [robot.leg_rows("state", layout.STATE, name, 2).ravel() for name in "qv"]
    base = [robot.base_rows(name, n)[0] for name, n in (("position", 3), ("quaternion", 4), ("velocity", 3), ("omega", 3))]
    return np.concatenate(hips + (base if environment == "ground" else []))


@pytest.mark.parametrize("environment", ["suspended", "ground"])
@pytest.mark.parametrize("backend", ["simple", "full"])
def test_error_falls_with_the_square_of_the_step(backend, environment):
    coarse, middle, fine = (final(backend, environment, h) for h in (0.2, 0.1, 0.05))
    order = np.log2(np.abs(coarse - middle) / np.abs(middle - fine))
    assert np.median(order) == pytest.approx(2.0, abs=0.05)
    whole = np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    assert whole == pytest.approx(2.0, abs=0.1)
    assert np.abs(middle - fine)[:8].max() < 1e-3, "rad: the error of the 50 us step itself is a third of this"


def test_what_is_not_kept_exactly_drifts_with_the_square_of_the_step():
    """Energy and momentum of a tumbling robot without dampers: a quarter of the drift for half the step."""

    def drift(h: float) -> np.ndarray:
        rng = np.random.default_rng(3)
        sim = undamped(BatchSim("simple", 1, gravity=0.0))
        turn = rng.normal(size=4)
        sim.set_state(
            q=rng.uniform(-0.3, 0.3, 8), qd=rng.normal(0, 0.02, 8), position=(0.0, 0.0, 1e3), quaternion=turn / np.linalg.norm(turn),
            velocity=rng.normal(0, 0.1, 3), angular_velocity=rng.normal(0, 0.03, 3),
        )  # fmt: skip
        robot = Interpreter(sim, h)
        seen, most = Seen(sim, robot), np.zeros(3)
        start = motion(seen)
        for _ in range(8):
            for _ in range(round(1.0 / h)):
                robot.step(np.full((1, 8), NEUTRAL))
            now = motion(seen)
            energy = now.kinetic + now.potential - start.kinetic - start.potential
            moved = [energy, np.linalg.norm(now.linear - start.linear), np.linalg.norm(now.angular - start.angular)]
            most = np.maximum(most, np.abs(moved))
        return most

    assert drift(0.1) / drift(0.05) == pytest.approx(np.full(3, 4.0), rel=0.1)
