"""Springs, what relaxes, play and stops: against closed forms, and forces against the potentials that they come from."""

from __future__ import annotations

from math import exp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stepped_laws import H, free_decay, modulus, parameters

from hamr_dynamics.effects.law import Joint, Pair
from hamr_dynamics.effects.library import find


@pytest.mark.parametrize("cubic", [0.02, -0.02])
def test_a_cubic_spring_shifts_the_resonance_with_the_amplitude(cubic):
    """By 3/8 k3 A^2 / k of it, against the linear spring with the same steps."""
    (_, linear), (_, hard) = (free_decay("cubic_stiffness", "cubic", 10, cubic=x) for x in (0.0, cubic))
    assert hard / linear - 1.0 == pytest.approx(3 / 8 * cubic, rel=0.02)


def test_structural_damping_loses_the_same_at_every_frequency():
    losses = [modulus("structural_damping", "ladder", omega, loss=0.1, time=1.0).imag for omega in (0.2, 0.5, 1.0, 2.0, 5.0)]
    assert losses == pytest.approx([0.1] * 5, rel=0.06)


@pytest.mark.parametrize("rise", [0.8, 1.4])
def test_fractional_damping_grows_as_a_power_of_the_frequency(rise):
    found = {w: modulus("structural_damping", "fractional", w, loss=0.1, time=1.0, rise=rise) for w in (0.5, 1.0, 2.0)}
    times = 4.0 ** np.arange(-2.5, 3.0)
    for w, x in found.items():  # Maxwell elements, each a factor of four later and so much softer
        exact = 0.1 * np.log(4.0) / (0.5 * np.pi) * np.sum(times ** (-np.log(rise) / np.log(4.0)) * 1j * w * times / (1.0 + 1j * w * times))
        assert abs(x - exact) < 0.02 * abs(exact)
    assert found[2.0].imag / found[0.5].imag == pytest.approx(rise, rel=0.05)


def test_a_relaxing_spring_has_the_modulus_of_a_maxwell_element():
    for omega in (0.3, 1.0, 3.0):
        found, exact = modulus("viscoelasticity", "maxwell", omega, stiffness=0.2, time=1.0), 0.2 * omega * 1j / (1 + omega * 1j)
        assert abs(found - exact) < 0.02 * abs(exact)


def test_two_relaxing_springs_have_the_modulus_of_a_prony_series():
    for omega in (0.05, 0.3, 2.0):
        found = modulus("viscoelasticity", "two", omega, fast=0.2, slow=0.1, short=1.0, long=20.0)
        exact = 0.2 * omega * 1j / (1 + omega * 1j) + 0.1 * 20.0 * omega * 1j / (1 + 20.0 * omega * 1j)
        assert abs(found - exact) < 0.02 * abs(exact)


@pytest.mark.parametrize("skew", [-1.4, -1.0, -0.5, 0.0, 0.8])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_spring_with_hysteresis_follows_its_curves_out_and_back(skew, way):
    """dz/dx = 1 - (1 + skew) z out from nothing, 1 + (1 - skew) |z| back to where it bears nothing: both have closed solutions."""
    law, size, distance, steps = find("spring_hysteresis"), 0.7, 0.2, 4000
    p = parameters(law, size=size, distance=distance, skew=skew)
    z, v = (0.0,), way * 0.3 / (steps * H)
    with np.errstate(divide="ignore"):
        for _ in range(steps):
            push, z = law.law(Joint(0.0, v, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, z)
        x, out, back = 0.3 / distance, 1.0 + skew, 1.0 - skew
        top = (1.0 - exp(-out * x)) / out if out else x
        assert push.force == pytest.approx(-way * size * top, rel=1e-4)
        assert push.stiffness == pytest.approx(size / distance * (1.0 - out * top), rel=1e-3)
        travelled = 0.0
        while way * z[0] > 0.0:
            _, z = law.law(Joint(0.0, -0.1 * v, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, z)
            travelled += 0.1 * abs(v) * H / distance
    assert travelled == pytest.approx(np.log1p(back * top) / back, rel=1e-3)


@given(st.floats(-1.4, 0.9), st.floats(-0.5, 0.5), st.floats(-0.3, 0.3))
def test_a_loop_through_no_twist_does_not_jump_with_where_steps_end(skew, twist, way):
    """What a fit differentiates: the same way in one step or two, and from a little more twist or less."""
    law = find("spring_hysteresis")
    p = parameters(law, size=1.0, distance=1.0, skew=skew)

    def after(z: float, *ways: float) -> float:
        state = (z,)
        for part in ways:
            push, state = law.law(Joint(0.0, part / H, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, state)
        return push.force

    assert after(twist, way) == pytest.approx(after(twist, *(way / 64,) * 64), abs=1e-3 + 0.2 * ((1.0 + abs(skew)) * abs(way)) ** 3)
    for at in (0.0, twist, -way):  # the last is just through
        assert after(at + 1e-9, way) == pytest.approx(after(at - 1e-9, way), abs=1e-8)


@pytest.mark.parametrize("skew", [-0.8, 0.0, 0.6])
@pytest.mark.parametrize(("way", "steps"), [(1.0, 4000), (-1.0, 4000), (1.0, 3)])
def test_hysteresis_of_exponent_two_follows_its_curves_out_and_back(skew, way, steps):
    """dz/dx = 1 - (1 + skew) z^2 out from nothing, a tanh, and 1 + (1 - skew) z^2 back to where it bears nothing, a tan."""
    law, size, distance = find("spring_hysteresis", "squared"), 0.7, 0.2
    p, exact = parameters(law, size=size, distance=distance, skew=skew), 1e-4 if steps > 3 else 0.1
    z, v, out, back = (0.0,), way * 0.3 / (steps * H), np.sqrt(1.0 + skew), np.sqrt(1.0 - skew)
    for _ in range(steps):
        push, z = law.law(Joint(0.0, v, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, z)
    top = np.tanh(1.5 * out) / out
    assert push.force == pytest.approx(-way * size * top, rel=exact)
    assert push.stiffness == pytest.approx(size / distance * (1.0 - (out * top) ** 2), rel=10.0 * exact)
    travelled = 0.0
    while way * z[0] > 0.0:
        _, z = law.law(Joint(0.0, -0.1 * v, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, z)
        travelled += 0.1 * abs(v) * H / distance
    assert travelled == pytest.approx(np.arctan(back * top) / back, rel=10.0 * exact)


@pytest.mark.parametrize("skew", [-0.8, 0.0, 0.6])
def test_one_long_step_ends_at_the_limit_of_hysteresis(skew):
    law = find("spring_hysteresis", "squared")
    push, _ = law.law(Joint(0.0, 500.0 / H, 0.0, 1.0, 1.0, 0.0, H, 9.0), parameters(law, size=1.0, distance=1.0, skew=skew), (0.2,))
    assert push.force == pytest.approx(-1.0 / np.sqrt(1.0 + skew), rel=1e-3)


@pytest.mark.parametrize("rate", [0.1, 2.0])
def test_sliders_have_masings_loops(rate):
    """On the way back the curve is the first one twice as large (Masing 1926), at any rate."""
    law = find("spring_hysteresis", "sliders")
    p = parameters(law, width=0.4, stiffness1=0.3, stiffness2=0.2, stiffness3=0.4, stiffness4=0.1)
    z, force, step = (0.0,) * 4, [0.0], rate * H
    for way in [step] * round(1.0 / step) + [-step] * round(1.6 / step):
        push, z = law.law(Joint(0.0, way / H, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, z)
        force.append(float(push.force))
    first, back = np.split(np.array(force), [round(1.0 / step) + 1])
    assert first[-1] == pytest.approx(-(0.3 * 0.1 + 0.2 * 0.2 + 0.4 * 0.4 + 0.1 * 0.8))  # where all have yielded
    pushes = [law.law(Joint(0.0, way / H, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, (0.0,) * 4)[0] for way in (0.05, 0.15, 0.3, 0.6, 1.0)]
    assert [push.stiffness for push in pushes] == pytest.approx([1.0, 0.7, 0.5, 0.1, 0.0])  # of those that still hold
    way, there = step * np.arange(1, len(back) + 1), step * np.arange(len(first))
    assert back - first[-1] == pytest.approx(-2.0 * np.interp(0.5 * way, there, first), abs=1e-9)


@given(st.lists(st.floats(-0.3, 0.3), min_size=1, max_size=30))
def test_hysteresis_without_skew_is_dry_friction_with_presliding(ways):
    """As its entry in the library says: whatever the motion."""
    loop, friction, z, w = find("spring_hysteresis"), find("coulomb_friction", "presliding"), (0.0,), (0.0,)
    for way in ways:
        x = Joint(0.0, way / H, 0.0, 1.0, 1.0, 0.0, H, 9.0)
        one, z = loop.law(x, parameters(loop, size=0.7, distance=0.2, skew=0.0), z)
        other, w = friction.law(x, parameters(friction, level=0.7, distance=0.2), w)
        assert one.force == pytest.approx(other.force, abs=1e-12)


def test_play_leaves_the_actuators_spring_out_and_stops_never_pull():
    law = find("backlash")
    push, _ = law.law(Joint(0.01, 0.0, 0.0, 2.0, 1.0, 0.0, H, 9.0), parameters(law, play=0.02, share=0.7), ())
    assert push.force == pytest.approx(0.7 * 2.0 * 0.01)  # takes back the share of the spring
    push, _ = law.law(Joint(1.0, 0.0, 0.0, 2.0, 1.0, 0.0, H, 9.0), parameters(law, play=0.02, share=0.7), ())
    assert push.force == pytest.approx(0.7 * 2.0 * 0.02)
    stop = find("end_stop", "both")
    p = parameters(stop, stiffness=5.0, limit=0.3, damping=10.0)
    for q, v, force in ((0.2, 5.0, 0.0), (0.4, 0.0, -0.5), (-0.4, 0.0, 0.5), (0.4, -5.0, 0.0)):
        assert stop.law(Joint(q, v, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, ())[0].force == pytest.approx(force)


@pytest.mark.parametrize(("form", "energy"), [
    ("well", lambda q, p: -p["depth"] / (1.0 + ((q - p["centre"]) / p["width"]) ** 2)),
    ("valley", lambda q, p: p["stiffness"] * p["width"] ** 2 * np.sqrt(1.0 + ((q - p["centre"]) / p["width"]) ** 2)),
])  # fmt: skip
@pytest.mark.parametrize("q", [-1.5, -0.2, 0.4, 2.0])
def test_local_springs_are_gradients_too(form, energy, q):
    law, eps = find("configuration_dependent_stiffness", form), 1e-4
    p = parameters(law, centre=0.3, width=0.5) | {law.sizes[0].name: np.float64(0.7)}
    push, _ = law.law(Joint(q, 0.0, 0.0, 1.0, 1.0, 0.0, H, 9.0), p, ())
    assert push.force == pytest.approx(-(energy(q + eps, p) - energy(q - eps, p)) / (2 * eps), abs=1e-7)
    assert push.stiffness == pytest.approx((energy(q + eps, p) - 2 * energy(q, p) + energy(q - eps, p)) / eps**2, abs=1e-6)


def pair(q, v=(0.0, 0.0), drive=(0.3, -0.2)) -> Pair:
    return Pair(tuple(q), tuple(v), drive, (1.5, 0.8), (1.0, 1.0), H)


@given(st.integers(-400, 399).map(lambda k: (k + 0.5) * 1e-4), st.floats(-30.0, 30.0), st.sampled_from(["upper", "lower", "both"]))
def test_a_stop_pushes_for_the_part_of_a_step_in_which_it_touches(depth, rate, form):
    """The mean over a step at a steady rate; so no run jumps with the step in which it hits."""
    stop = find("end_stop", form)
    p, damper = parameters(stop, stiffness=5.0, limit=0.3, damping=1e-9), parameters(stop, stiffness=1e-9, limit=0.3, damping=2.0)
    side = -1.0 if form == "lower" else 1.0

    def push(depth: float, p: dict):
        return stop.law(Joint(side * (0.3 + depth), side * rate, 0.0, 1.0, 1.0, 0.0, 1e-3, 9.0), p, ())[0]

    along = depth + rate * 1e-3 * ((np.arange(1000) + 0.5) / 1000 - 0.5)
    assert -side * float(push(depth, p).force) == pytest.approx(5.0 * np.mean(np.maximum(along, 0.0)), abs=1e-5)
    assert float(push(depth, damper).damping) == pytest.approx(2.0 * np.mean(along > 0.0), abs=3e-3)


def transmission_energy(q, p) -> float:
    """Springs on the actuators' side and drive, with the map, less the same without it."""
    (s, r), total = q, 0.0
    for i, k in enumerate((1.5, 0.8)):
        travel = q[i] + sum(x * s ** int(name[3]) * r ** int(name[4]) for name, x in p.items() if name.startswith(f"a{i + 1}"))
        spring = p[f"share{i + 1}"] * k
        total += 0.5 * spring * (travel**2 - q[i] ** 2) - (0.3, -0.2)[i] * (travel - q[i])
    return total


def stiffness_energy(q, p) -> float:
    return sum(value * q[0] ** int(name[1]) * q[1] ** int(name[2]) for name, value in p.items())


def oblique_energy(q, p) -> float:
    across = q[0] * np.cos(p["direction"]) + q[1] * np.sin(p["direction"]) - p["centre"]
    return p["stiffness"] * p["width"] * np.hypot(p["width"], across)


@pytest.mark.parametrize(
    ("effect", "form", "energy"),
    [("configuration_dependent_transmission", "map", transmission_energy),
     ("configuration_dependent_transmission", "fine_map", transmission_energy),
     ("configuration_dependent_stiffness", "potential", stiffness_energy),
     ("configuration_dependent_stiffness", "oblique", oblique_energy)],
)  # fmt: skip
def test_springs_are_gradients(effect, form, energy, rng):
    law = find(effect, form)
    p = {x.name: rng.uniform(0.1, 0.6) for x in law.parameters}
    q, eps = np.array([0.3, -0.2]), 1e-4
    push, _ = law.law(pair(q), p, ())
    for i, step in enumerate(np.eye(2) * eps):
        assert push.force[i] == pytest.approx(-(energy(q + step, p) - energy(q - step, p)) / (2 * eps), rel=1e-6)
    if energy is not transmission_energy:  # there the machine's own spring is taken away, which the implicit step counts by itself
        a, b = np.eye(2) * eps
        mixed = (energy(q + a + b, p) - energy(q + a - b, p) - energy(q - a + b, p) + energy(q - a - b, p)) / (4 * eps**2)
        own = [(energy(q + step, p) - 2 * energy(q, p) + energy(q - step, p)) / eps**2 for step in (a, b)]
        assert push.stiffness == pytest.approx((own[0], mixed, own[1]), rel=1e-4)


def test_inertia_that_varies_does_no_work(rng):
    """The velocity force takes from the motion what the mass matrix gains: v . f = - v dM/dt v / 2."""
    law = find("configuration_dependent_inertia", "polynomial")
    p = {x.name: rng.normal() for x in law.parameters}
    q, v, eps = rng.normal(0, 0.3, 2), rng.normal(0, 1, 2), 1e-6

    def mass(at):
        m11, m12, m22 = law.law(pair(at), p, ())[0].mass
        return np.array([[m11, m12], [m12, m22]])

    rate = (mass(q + eps * v) - mass(q - eps * v)) / (2 * eps)
    assert v @ law.law(pair(q, v), p, ())[0].force == pytest.approx(-0.5 * v @ rate @ v, rel=1e-6)
