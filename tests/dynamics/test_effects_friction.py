"""Friction and damping against closed forms."""

from __future__ import annotations

from math import cos, exp, pi, sin

import numpy as np
import pytest
from stepped_laws import H, free_decay, parameters

from hamr_dynamics.effects.dragged import dragged
from hamr_dynamics.effects.law import Joint, Push
from hamr_dynamics.effects.library import find


def test_coulomb_friction_takes_the_same_amplitude_every_turn():
    """4 F / k."""
    tops, _ = free_decay("coulomb_friction", "sign", 8, level=0.02, width=1e-4)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.01)
    tops, _ = free_decay("coulomb_friction", "presliding", 8, level=0.02, distance=1e-3)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.02)
    tops, _ = free_decay("coulomb_friction", "asymmetric", 8, level=0.02, skew=0.5, width=1e-4)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.01)  # 2 (F+ + F-) / k
    tops, _ = free_decay("stribeck_friction", "lorentzian", 3, level=0.02, excess=0.05, speed=1e-4, width=1e-5)
    assert -np.diff(tops) == pytest.approx(np.full(3, 0.08), rel=0.02)  # the excess is gone when it slides


@pytest.mark.parametrize("way", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_bristles_hold_on_the_part_of_a_step_before_they_slide(way, sign):
    """All at once, from 0.9 of what they bear: so their spring does not jump with the step in which they begin to."""
    law = find("coulomb_friction", "lugre")
    p = parameters(law, level=0.7, time=0.0, distance=1.0, sharpness=1.0)
    push, _ = law.law(Joint(0.0, sign * way / H, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, (0.0, 0.9 * sign))
    assert push.stiffness == pytest.approx(0.7 * min(1.0, 0.1 / way))
    assert push.force == pytest.approx(-sign * 0.7 * min(1.0, 0.9 + way))


@pytest.mark.parametrize("drive", [0.1, -0.1])
def test_friction_grows_with_the_load(drive):
    """4 (F + share |drive|) / k of every turn about where the drive holds the spring."""
    tops, _ = free_decay("coulomb_friction", "loaded", 6, drive=drive, level=0.01, share=0.1, width=1e-4)
    assert -np.diff(tops) == pytest.approx(np.full(6, 0.08), rel=0.01)


@pytest.mark.parametrize(("forward", "backward"), [(0.03, 0.01), (0.01, 0.03), (0.02, 0.0), (0.0, 0.02)])
def test_friction_of_two_directions_resists_each_by_a_level_of_its_own(forward, backward):
    """Slow steady sliding, ten widths fast, feels one level, and neither level pushes along the motion at any rate, even alone."""
    law, width = find("coulomb_friction", "asymmetric"), 1e-4
    level, difference = 0.5 * (forward + backward), 0.5 * (forward - backward)
    p = parameters(law, level=level, skew=difference / level, width=width)

    def push(rate: float) -> Push:
        return law.law(Joint(0.0, rate, 0.4, 1.0, 1.0, 0.0, 1e-3, 9.0), p, ())[0]

    assert float(push(10.0 * width).force) == pytest.approx(-forward, rel=0.01, abs=1e-4)
    assert float(push(-10.0 * width).force) == pytest.approx(backward, rel=0.01, abs=1e-4)
    for share in (-1e3, -10.0, -1.0, -0.3, -0.01, 0.0, 0.01, 0.3, 1.0, 10.0, 1e3):
        rate, step = share * width, 1e-5 * width
        assert float(push(rate).force) * share <= 0.0
        s = share / np.hypot(share, 1.0)
        assert float(push(rate).force) == pytest.approx(-(level * s + difference * s * s), rel=1e-9, abs=1e-15)
        slope = (float(push(rate + step).force) - float(push(rate - step).force)) / (2.0 * step)
        assert float(push(rate).damping) == pytest.approx(-slope, rel=1e-5, abs=1e-8 * (forward + backward) / width)


def test_no_direction_has_less_than_no_friction():
    """So no fit finds a friction that drives the joint."""
    law = find("coulomb_friction", "asymmetric")
    (level,), (skew,) = law.sizes, (p for p in law.shapes if p.name == "skew")
    assert (level.low, skew.low, skew.high) == (0.0, -1.0, 1.0)


@pytest.mark.parametrize(("effect", "form", "sizes"), [
    ("coulomb_friction", "sign", {"level": 0.02}),
    ("coulomb_friction", "asymmetric", {"level": 0.02, "skew": 0.5}),
    ("coulomb_friction", "loaded", {"level": 0.02, "share": 0.1}),
    ("stribeck_friction", "lorentzian", {"level": 0.02, "excess": 0.03}),
    ("stribeck_friction", "loaded", {"level": 0.02, "share": 0.1, "boost": 0.5}),
])  # fmt: skip
@pytest.mark.parametrize("rate", [-3e-3, 0.0, 1e-3, 5e-3])
def test_friction_at_standstill_damps_as_its_force_changes(effect, form, sizes, rate):
    """-d force / d rate for the implicit step, without which so steep a force would not be stable."""
    law = find(effect, form)
    p = parameters(law, width=5e-3, **sizes)
    before, at, after = (law.law(Joint(0.0, v, 0.4, 1.0, 1.0, 0.0, 1e-3, 9.0), p, ())[0] for v in (rate - 1e-7, rate, rate + 1e-7))
    # the bell of Stribeck's falls little within the width
    assert float(at.damping) == pytest.approx(-(float(after.force) - float(before.force)) / 2e-7, rel=5e-3)


@pytest.mark.parametrize(("rate", "share"), [(1e-3, 1.5), (0.2, 1.25), (20.0, 1.0)])
def test_friction_under_load_falls_with_speed(rate, share):
    """By all of its boost near standstill, by half of it at the speed, by none of it far beyond; for the constant part and the load's."""
    law = find("stribeck_friction", "loaded")
    p = parameters(law, level=0.02, share=0.1, boost=0.5, speed=0.2, width=1e-5)
    for way in (1.0, -1.0):
        push, _ = law.law(Joint(0.0, way * rate, -0.3, 1.0, 1.0, 0.0, 1e-3, 9.0), p, ())
        assert float(push.force) == pytest.approx(-way * share * (0.02 + 0.1 * 0.3), rel=1e-3)


@pytest.mark.parametrize("sharpness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(("effect", "given", "slow", "fast"), [
    ("coulomb_friction", {"level": 0.02}, 0.02, 0.02),
    ("stribeck_friction", {"level": 0.02, "excess": 0.03, "speed": 0.1}, 0.05, 0.02),
])  # fmt: skip
def test_bristles_slide_at_their_limit_and_creep_back(effect, given, slow, fast, sharpness):
    """Slowly at the breakaway force, fast at the level, both ways; turned back they bear less by their stiffness times the way."""
    law, h, distance = find(effect, "lugre"), 1e-3, 1e-3
    p = parameters(law, time=0.0, distance=distance, sharpness=sharpness, **given)

    def pulled(v: float, steps: int, z: tuple) -> tuple[float, tuple]:
        for _ in range(steps):
            push, z = law.law(Joint(0.0, v, 0.0, 1.0, 1.0, 0.0, h, 9.0), p, z)
        return float(push.force), z

    for way in (1.0, -1.0):
        force, z = pulled(way * 2e-3, 20_000, (0.0, 0.0))
        assert force == pytest.approx(-way * slow, rel=1e-3)
        back, _ = pulled(-way * 2e-3, 1, z)
        # twice, where what slid forward now bends back
        assert back - force == pytest.approx(way * slow * (2.0 - sharpness) * 2e-3 * h / distance, rel=0.01)
        assert pulled(way * 5.0, 200, (0.0, 0.0))[0] == pytest.approx(-way * fast, rel=1e-3)


@pytest.mark.parametrize("tail", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0, 5.0])
def test_bristles_lose_their_excess_as_fast_as_their_tail_says(ratio, tail):
    law, z = find("stribeck_friction", "lugre"), (0.0, 0.0)
    p = parameters(law, level=0.02, excess=0.03, speed=0.1, tail=tail, time=0.0, distance=1e-3)
    for _ in range(2000):
        push, z = law.law(Joint(0.0, 0.1 * ratio, 0.0, 1.0, 1.0, 0.0, 1e-3, 9.0), p, z)
    left = (1.0 - tail) * exp(-(ratio**2)) + tail / (1.0 + ratio**2)
    assert float(push.force) == pytest.approx(-(0.02 + 0.03 * left), abs=0.07 * 0.03 * (1.0 - tail) + 1e-5)


@pytest.mark.parametrize("sharpness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("effect", ["coulomb_friction", "stribeck_friction"])
def test_a_damper_in_the_bristles_damps_what_sticks_and_not_what_slides(effect, sharpness):
    """A spring beside a damper at small amplitude; its derivative for the implicit step is that of the force."""
    law, h = find(effect, "lugre"), 1e-4
    p = parameters(law, time=1.5, distance=0.1, level=0.02, sharpness=sharpness)  # a damper of 0.3
    z, omega, found = (0.0, 0.0), 50.0, 0.0j
    for k in range(8 * round(2 * pi / omega / h)):
        v = 1e-5 * omega * cos(omega * k * h)  # far below the distance
        push, z = law.law(Joint(0.0, v, 0.0, 1.0, 1.0, 0.0, h, 9.0), p, z)
        found -= float(push.force) * (sin(omega * k * h) + 1j * cos(omega * k * h)) * 2 * h * omega / (16 * pi)
    assert found / 1e-5 == pytest.approx(0.02 / 0.1 + 1j * 0.3 * omega, rel=0.02)
    for _ in range(20_000):
        push, z = law.law(Joint(0.0, 1.0, 0.0, 1.0, 1.0, 0.0, h, 9.0), p, z)
    assert float(push.force) == pytest.approx(-0.02, rel=1e-3)
    for v in (0.2, -0.2):
        ahead, near = (
            [law.law(Joint(0.0, v + d, 0.0, 1.0, 1.0, 0.0, h, 9.0), p | {"time": np.float64(time)}, (0.4, 0.4))[0] for time in (1.5, 0.0)]
            for d in (1e-6, -1e-6)
        )
        damped = [float(one.force) - float(other.force) for one, other in (ahead, near)]  # without the bristles' spring
        assert float(near[0].damping) == pytest.approx(-(damped[0] - damped[1]) / 2e-6, rel=1e-3)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 50.0])
def test_what_is_dragged_follows_the_exact_curve(share):
    """z = limit - (limit - z0) exp(-way / (length limit)), in steps that are a share of the length: to second order, however long."""
    length, limit, way = 0.4, 0.7, 0.8
    steps = max(1, round(way / (share * length)))
    for sign in (1.0, -1.0):
        z = 0.3 * sign
        for _ in range(steps):
            z, _ = dragged(z, -sign * max(way / steps, share * length), length, limit)
        exact = -limit + (limit + 0.3) * exp(-max(way, steps * share * length) / (length * limit))
        assert sign * z == pytest.approx(exact, abs=min(0.06 * share**2, 6e-3))
        ahead, behind, slope = (dragged(0.3, sign * 0.2 + d, length, limit) for d in (1e-6, -1e-6, 0.0))
        assert slope[1] == pytest.approx((ahead[0] - behind[0]) / 2e-6, rel=1e-5)


def test_quadratic_damping_decays_as_a_hyperbola():
    """1/A grows by 8 c / (3 m) a turn."""
    tops, _ = free_decay("quadratic_damping", "square", 8, coefficient=0.01)
    assert np.diff(1.0 / tops) == pytest.approx(np.full(8, 8 * 0.01 / 3), rel=0.02)


def test_a_film_between_plates_damps_as_the_inverse_cube_of_their_distance():
    """Stefan's law, its value at rest apart: half the gap is eight times the damping, and a closed gap is still a film."""
    law = find("configuration_dependent_damping", "squeeze_film")
    p = parameters(law, film=0.01, approach=-0.5)
    for q, damping in ((0.0, 0.0), (-1.0, 0.07), (-1.5, 0.63), (2.0, 0.01 / 8 - 0.01), (-5.0, 9.99)):
        push, _ = law.law(Joint(q, 2.0, 0.0, 1.0, 1.0, 0.0, H, 0.4), p, ())
        assert push.damping == pytest.approx(damping)
        assert push.force == -push.damping * 2.0


@pytest.mark.parametrize(("form", "given"), [("polynomial", {"curvature": -3.0}), ("local", {"extra": -3.0, "width": 5.0}),
                                             ("squeeze_film", {"film": 3.0, "approach": -0.5})])  # fmt: skip
def test_damping_that_depends_on_the_angle_leaves_none_rather_than_drive(form, given):
    law = find("configuration_dependent_damping", form)
    push, _ = law.law(Joint(1.0, 2.0, 0.0, 1.0, 1.0, 0.0, H, 0.4), parameters(law, **given), ())
    assert push.damping == -0.4 and push.force == 0.4 * 2.0
