"""What nature keeps, the step keeps: energy without dampers, momentum without contact and gravity, and the fall of the centre of mass.

Bounds are two to three times what the step of 50 us drifts by; docs/physics.md has the figures.
"""

from __future__ import annotations

import numpy as np
import pytest
from mechanics import motion, undamped

from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim

ROBOTS = 3
CHECKS, SPELL = 15, 20.0  # looked at every 20 ms for 300 ms, an episode
GRAVITY = value("robot.gravity")
NEUTRAL = value("actuator.neutral_voltage")
backends = pytest.mark.parametrize("backend", ["simple", "full"])


def hold(sim: BatchSim, volts: np.ndarray | float = NEUTRAL) -> None:
    """One spell; voltages (8,), or one row for each of its five parts."""
    parts = np.broadcast_to(volts, (5, 8)).repeat(80, axis=0)
    sim.step_voltages(np.broadcast_to(parts, (sim.n, 400, 8)))


def parts(spell: int) -> np.ndarray:
    """(5, 1) numbers of the parts of a spell."""
    return (5 * spell + np.arange(5.0))[:, None]


def thrown(backend: str, rng, *, gravity: float) -> BatchSim:
    """Robots tumbling far above the ground, legs in motion."""
    sim = BatchSim(backend, ROBOTS, gravity=gravity, block=16)
    turn = rng.normal(size=(ROBOTS, 4))
    sim.set_state(
        q=rng.uniform(-0.3, 0.3, (ROBOTS, 8)), qd=rng.normal(0, 0.02, (ROBOTS, 8)), position=(0.0, 0.0, 1e4),
        quaternion=turn / np.linalg.norm(turn, axis=1, keepdims=True), velocity=rng.normal(0, 0.1, (ROBOTS, 3)),
        angular_velocity=rng.normal(0, 0.03, (ROBOTS, 3)),
    )  # fmt: skip
    return sim


def energies(sim: BatchSim, gravity: float) -> np.ndarray:
    return np.array([[m.kinetic, m.potential] for m in (motion(sim, i, gravity=gravity) for i in range(ROBOTS))])


@backends
@pytest.mark.parametrize("gravity", [0.0, GRAVITY])
def test_undamped_legs_keep_their_energy(backend, gravity, rng):
    """On a fixed chassis, swings up to 0.3 rad, 300 ms: within 4e-4 at any time."""
    sim = undamped(BatchSim(backend, ROBOTS, environment="suspended", gravity=gravity, block=16))
    sim.set_state(q=rng.uniform(-0.3, 0.3, (ROBOTS, 8)), qd=rng.normal(0, 0.02, (ROBOTS, 8)))
    start = energies(sim, gravity).sum(axis=1)
    scale = energies(sim, 0.0).sum(axis=1)
    exchanged = np.zeros(ROBOTS)
    for _ in range(CHECKS):
        hold(sim)
        now = energies(sim, gravity)
        assert np.abs(now.sum(axis=1) - start).max() < 4e-4 * scale.min()
        exchanged = np.maximum(exchanged, now[:, 0])
    assert (exchanged > 0.3 * scale).all(), "the legs really swing"
    assert sim.counts.sum() == 0, "the stops stay out of it"


@backends
@pytest.mark.parametrize("gravity", [0.0, GRAVITY])
def test_an_undamped_robot_in_the_air_keeps_its_energy(backend, gravity, rng):
    """Tumbling at 30 rad/s with legs swinging, 300 ms: within 3e-3 of what it has and 3e-4 of what it falls."""
    sim = undamped(thrown(backend, rng, gravity=gravity))
    start, scale = energies(sim, gravity).sum(axis=1), energies(sim, 0.0).sum(axis=1)
    for check in range(1, CHECKS + 1):
        hold(sim)
        fallen = 1.475 * gravity**2 * (check * SPELL) ** 2 / 2
        drift = np.abs(energies(sim, gravity).sum(axis=1) - start)
        assert (drift < 3e-3 * scale + 3e-4 * fallen).all()
    assert sim.counts.sum() == 0


@backends
def test_dampers_only_ever_take_energy(backend, rng):
    """With dampers as published, energy falls from look to look and is gone after 300 ms."""
    sim = BatchSim(backend, ROBOTS, environment="suspended", gravity=0.0, block=16)
    sim.set_state(q=rng.uniform(-0.3, 0.3, (ROBOTS, 8)))
    before = start = energies(sim, 0.0).sum(axis=1)
    for _ in range(CHECKS):
        hold(sim)
        now = energies(sim, 0.0).sum(axis=1)
        assert (now < before).all()
        before = now
    assert (before < 0.01 * start).all()


@backends
def test_driven_legs_cannot_move_the_robot_in_empty_space(backend, rng):
    """Full-voltage square waves, no gravity: linear and angular momentum stay, whatever the legs do."""
    sim = thrown(backend, rng, gravity=0.0)
    start = [motion(sim, i) for i in range(ROBOTS)]
    exchange = 0.0
    for check in range(5):
        hold(sim, NEUTRAL + 90.0 * np.sign(np.sin(0.7 * parts(check) + np.arange(8.0))))
        for i, before in enumerate(start):
            now = motion(sim, i)
            assert np.abs(now.linear - before.linear).max() / now.mass < 1.5e-3, "a millimetre per second"
            assert np.abs(now.angular - before.angular).max() < 5e-3 * np.linalg.norm(before.angular)
            exchange = max(exchange, np.abs(sim.angular_velocity[i]).max())
    assert exchange > 0.03, "the chassis answers the legs"


@backends
def test_centre_of_mass_falls_on_a_parabola(backend, rng):
    """Legs driven all the while; 300 ms of flight and 441 mm of fall: within 0.1 mm."""
    sim = thrown(backend, rng, gravity=GRAVITY)
    start = [motion(sim, i) for i in range(ROBOTS)]
    for check in range(1, CHECKS + 1):
        hold(sim, NEUTRAL + 60.0 * np.sin(0.9 * parts(check) + np.arange(8.0)))
        t = check * SPELL
        for i, before in enumerate(start):
            expected = before.com + before.linear / before.mass * t - np.array([0.0, 0.0, GRAVITY * t * t / 2])
            assert np.abs(motion(sim, i).com - expected).max() < 0.1


def test_simple_and_full_are_the_same_robot_to_first_order():
    """Mass, centre of mass at rest, and (lightly driven) the same motion: what differs is of second order."""
    sims = {backend: BatchSim(backend, 1, environment="suspended", gravity=0.0) for backend in ("simple", "full")}
    still = {backend: motion(BatchSim(backend, 1)) for backend in sims}
    assert still["simple"].mass == pytest.approx(1.47499, abs=1e-5)
    assert still["simple"].mass == pytest.approx(still["full"].mass, rel=1e-12)
    assert still["simple"].com == pytest.approx(still["full"].com, abs=1e-9)
    amplitude = {}
    for volts in (1.0, 2.0):
        for sim in sims.values():
            sim.reset()
            for spell in range(2):
                hold(sim, NEUTRAL + volts * np.sin(2.0 * parts(spell) + np.arange(8.0)))
        amplitude[volts] = np.abs(sims["simple"].q - sims["full"].q).max() / np.abs(sims["full"].q).max()
    assert amplitude[1.0] < 5e-3
    assert amplitude[2.0] == pytest.approx(2 * amplitude[1.0], rel=0.2), "the difference grows with the square"
