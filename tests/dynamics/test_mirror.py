"""Left and right are mirror images: mirrored voltages give the mirrored motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hamr_dynamics.batch import BatchSim
from hamr_dynamics.plant import Plant, plant

SWAP = [4, 5, 6, 7, 0, 1, 2, 3]  # fl rl fr rr -> fr rr fl rl
POINT, SPIN, TURN = np.array([1, -1, 1]), np.array([-1, 1, -1]), np.array([1, -1, 1, -1])


def symmetric(backend: str) -> Plant:
    """The robot with the published chassis' products of inertia across y, 0.003 % of its moments, left out."""
    robot = plant(backend)
    xx, yy, zz, _, xz, _ = robot.chassis["inertia"]
    return replace(robot, chassis={**robot.chassis, "inertia": (xx, yy, zz, 0.0, xz, 0.0)})


def mirrored(sim: BatchSim) -> dict[str, np.ndarray]:
    """The state seen in a mirror along x and z: y flips, and angles about x and z."""
    return {
        "q": -sim.q[:, SWAP], "qd": -sim.qd[:, SWAP], "position": sim.position * POINT, "quaternion": sim.quaternion * TURN,
        "velocity": sim.velocity * POINT, "angular_velocity": sim.angular_velocity * SPIN,
    }  # fmt: skip


@pytest.mark.parametrize("backend", ["simple", "simple_published", "full"])
@pytest.mark.parametrize(("environment", "steps", "tolerance"), [("suspended", 400, 1e-12), ("ground", 400, 1e-9)])
def test_mirrored_voltages_give_the_mirrored_motion(backend, environment, steps, tolerance, rng):
    """20 ms of random voltages; on the ground the feet strike and slip."""
    robot = symmetric(backend)
    one, other = (BatchSim(robot, 3, environment=environment) for _ in range(2))
    start = {
        "q": rng.uniform(-0.2, 0.2, (3, 8)), "qd": rng.normal(0, 0.05, (3, 8)), "velocity": rng.normal(0, 0.05, (3, 3)),
        "angular_velocity": rng.normal(0, 0.005, (3, 3)),
    }  # fmt: skip
    if environment == "suspended":
        start = {name: start[name] for name in ("q", "qd")}
    one.set_state(**start)
    other.set_state(**mirrored(one))
    volts = rng.uniform(0, 225, (3, steps // 40, 8)).repeat(40, axis=1)
    one.step_voltages(volts)
    other.step_voltages(225.0 - volts[..., SWAP])
    for name, x in mirrored(one).items():
        assert np.abs(x - getattr(other, name)).max() < tolerance, name
    assert np.abs(one.q + one.q[:, SWAP]).max() > 0.05, "the motion itself is not symmetric"


def test_forces_and_tips_are_mirrored_too(rng):
    """Tips and tip forces lie along +y of the chassis, hip torques about its axes."""
    one, other = (BatchSim("full", 3, environment="suspended") for _ in range(2))
    volts = rng.uniform(0, 225, (3, 8))
    one.step_voltages(volts[:, None].repeat(20, axis=1))
    other.step_voltages(225.0 - volts[:, None, SWAP].repeat(20, axis=1))
    seen, image = one.observe(volts), other.observe(225.0 - volts[:, SWAP])
    for name in ("tip", "tip_rate", "tip_force", "torque"):
        assert image[name] == pytest.approx(-seen[name][:, SWAP], abs=1e-12), name
