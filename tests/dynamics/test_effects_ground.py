"""Effects of the whole robot on the ground: slopes, payloads, tethers, air, feet, and a leg of another size."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.effects.effects_file import EffectsFile, PlacedEffect
from hamr_dynamics.plant import plant

G = value("robot.gravity")
PERIOD_MS = 4.0


def robot(*effects: PlacedEffect, environment: str = "ground", air: bool = False, gravity: float = G) -> BatchSim:
    """One of HAMR-simple, standing; or high in the air."""
    added = effects or (PlacedEffect("air_drag", "quadratic", (), {"coefficient": 0.0}),)  # off, but in the same kernel
    sim = BatchSim("simple", 1, environment=environment, gravity=gravity, effects=EffectsFile(added))
    if air:
        sim.set_state(position=(0.0, 0.0, 500.0))
    return sim


def mass(sim: BatchSim) -> float:
    """Of the whole robot, g."""
    legs = [sum(body.mass for body in plant("simple").leg((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), plant("simple").parameters(leg)).bodies)
            for leg in ("fl", "rl", "fr", "rr")]  # fmt: skip
    return float(sim.body("mass")[0]) + sum(legs)


def rest(sim: BatchSim, periods: int) -> BatchSim:
    """The same after periods of the leg law at zero."""
    for _ in range(periods):
        sim.step_targets(np.zeros((1, 8)))
    return sim


def test_everything_falls_down_the_slope():
    sim = robot(PlacedEffect("gravity_tilt", "slope", (), {"roll": 0.2, "pitch": -0.3}), air=True)
    sim.step_voltages(np.full((1, 80, 8), 112.5))
    fall = sim.velocity[0] / PERIOD_MS / G
    assert np.abs(sim.q).max() < 1e-9  # nothing pulls on the joints
    assert fall == pytest.approx([-np.sin(0.3) * np.cos(0.2), -np.sin(0.2), -np.cos(0.2) * np.cos(0.3)], abs=1e-6)


def test_a_tether_moves_the_whole_mass():
    """By force over mass, once the legs follow: the mean over a hundred milliseconds of falling."""
    pull = 1e-3  # N
    towed, free = robot(PlacedEffect("tether_force", "constant", (), {"x": pull, "y": -2 * pull, "z": 0.0}), air=True), robot(air=True)
    for sim in (towed, free):
        rest(sim, 25)
    expected = np.array([pull, -2 * pull, 0.0]) / mass(free) * 100.0
    assert towed.velocity[0] - free.velocity[0] == pytest.approx(expected, abs=0.03 * expected[0])


def test_a_tethers_spring_and_the_air_brake():
    spring = robot(PlacedEffect("tether_force", "spring", (), {"stiffness": 0.5}), air=True)  # 5e-4 N/mm
    spring.set_state(position=(3.0, -2.0, 500.0))
    rest(spring, 5)
    pull = 5e-4 * np.array([3.0, -2.0, 0.0]) / mass(spring)
    assert spring.velocity[0, :2] == pytest.approx(-pull[:2] * 5 * PERIOD_MS, rel=0.1)
    drag = robot(PlacedEffect("air_drag", "quadratic", (), {"coefficient": 1e-2}), air=True, gravity=0.0)  # N/(mm/ms)^2
    drag.set_state(velocity=(0.3, 0.0, 0.0))
    rest(drag, 25)
    assert 1 / drag.velocity[0, 0] - 1 / 0.3 == pytest.approx(1e-2 / mass(drag) * 100.0, rel=0.01)


def test_feet_slide_where_the_slope_is_steeper_than_friction():
    """At g (sin a - mu cos a); the same slope holds the robot on rougher ground."""
    slope = PlacedEffect("gravity_tilt", "slope", (), {"roll": 0.0, "pitch": 0.25})
    smooth = PlacedEffect("ground_friction", "factor", ("all",), {"change": -0.8})
    sliding, held = rest(robot(slope, smooth), 25), rest(robot(slope), 25)
    before = sliding.velocity[0, 0]
    rest(sliding, 25)
    friction = 0.2 * value("contact.friction")
    expected = G * (np.sin(0.25) - friction * np.cos(0.25)) * 100.0
    assert sliding.velocity[0, 0] - before == pytest.approx(expected, rel=0.05)
    assert abs(held.velocity[0, 0]) < 0.01 * expected


def test_payload_and_soft_ground_let_it_sink():
    """Softer ground takes the same weight deeper; a payload of the robot's own mass at its centre doubles every sag."""
    stiffness, plain = value("contact.stiffness"), robot()
    com = plant("simple").chassis["com"]
    payload = PlacedEffect("added_mass", "point", (), {"mass": mass(plain) * 1e-3, **dict(zip("xyz", np.array(com) * 1e-3, strict=True))})
    soft = PlacedEffect("ground_compliance", "factor", ("all",), {"stiffness": -0.5, "damping": 0.0})
    plain, loaded, soft = (rest(sim, 60) for sim in (plain, robot(payload), robot(soft)))
    assert mass(loaded) == pytest.approx(2 * mass(plain))
    foot = mass(plain) * G / 4 / stiffness  # depth under a quarter of the weight
    assert plain.position[0, 2] - soft.position[0, 2] == pytest.approx(foot, rel=0.05)
    start = robot().position[0, 2]
    assert start - loaded.position[0, 2] == pytest.approx(2 * (start - plain.position[0, 2]), rel=0.05)


def test_a_leg_of_another_size_shows_on_the_ground_alone(rng):
    big = PlacedEffect("unit_scale", "common", ("fl",), {"change": 0.5})
    volts = rng.uniform(60, 160, (1, 400, 8))
    hung = [robot(*effects, environment="suspended") for effects in ((big,), ())]
    stood = [robot(*effects) for effects in ((big,), ())]
    for sim in (*hung, *stood):
        sim.step_voltages(volts)
    assert np.abs(hung[0].q - hung[1].q).max() < 1e-12
    assert np.abs(stood[0].q - stood[1].q).max() > 1e-4
    torque = [sim.observe(volts[:, -1])["torque"][0] for sim in hung]
    assert torque[0][:2] == pytest.approx(1.5 * torque[1][:2])
    assert torque[0][2:] == pytest.approx(torque[1][2:])


def test_machines_of_one_leg_know_none_of_these():
    from hamr_dynamics.effects.bank import Bank
    from hamr_dynamics.effects.library import library

    ground = {name for name, effect in library().items() if "ground" in effect.needs}
    assert ground == {"added_mass", "air_drag", "gravity_tilt", "ground_compliance", "ground_friction", "tether_force", "unit_scale"}
    assert not ground & {name for name, _ in Bank(2).forms}
