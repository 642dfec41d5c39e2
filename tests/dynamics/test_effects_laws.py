"""Laws against closed forms, stepped here by an integrator of our own; forces against the potentials that they come from."""

from __future__ import annotations

from math import atan, cos, exp, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_dynamics.effects.dragged import dragged
from hamr_dynamics.effects.force_table import hats
from hamr_dynamics.effects.law import Chassis, Input, Joint, Motion, Pair, Push, Scales, Signal
from hamr_dynamics.effects.library import find, library

UNIT = Scales(1.0, 1.0, 1.0, 1.0)
H = 0.01  # of an oscillator with mass 1, spring 1


def parameters(form, **given: float) -> dict[str, float]:
    """Neutral ones, but for those given."""
    values = {p.name: p.typical if p.shape else 0.0 for p in form.parameters} | given
    return {name: np.float64(value) for name, value in values.items()}  # 1 / 0 is infinite, as in the kernels


def free_decay(effect: str, form: str, turns: int, **given: float) -> tuple[np.ndarray, float]:
    """(amplitudes at successive maxima, angular frequency) of q'' + q = force of the law, from q = 1 at rest; leapfrog."""
    law = find(effect, form)
    p, z, q, v = parameters(law, **given), (0.0,) * law.states, 1.0, 0.0
    tops, times, t = [1.0], [0.0], 0.0
    while len(tops) <= turns:
        middle = q + 0.5 * H * v
        push, z = law.law(Joint(middle, v, 0.0, 1.0, 1.0, t, H, 9.0), p, z)
        before, v = v, v + H * (float(push.force) - middle) / (1.0 + 0.5 * H * float(push.damping))
        q, t = middle + 0.5 * H * v, t + H
        if before > 0.0 >= v:
            tops.append(q)
            times.append(t + H * v / (before - v))
    return np.array(tops), 2.0 * pi * turns / (times[-1] - times[0])


def test_coulomb_friction_takes_the_same_amplitude_every_turn():
    """4 F / k."""
    tops, _ = free_decay("coulomb_friction", "sign", 8, level=0.02, width=1e-4)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.01)
    tops, _ = free_decay("coulomb_friction", "presliding", 8, level=0.02, distance=1e-3)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.02)
    tops, _ = free_decay("coulomb_friction", "asymmetric", 8, level=0.02, difference=0.01, width=1e-4)
    assert -np.diff(tops) == pytest.approx(np.full(8, 0.08), rel=0.01)  # 2 (F+ + F-) / k
    tops, _ = free_decay("stribeck_friction", "lorentzian", 3, level=0.02, excess=0.05, speed=1e-4, width=1e-5)
    assert -np.diff(tops) == pytest.approx(np.full(3, 0.08), rel=0.02)  # the excess is gone when it slides


@pytest.mark.parametrize("sharpness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(("effect", "given", "slow", "fast"), [
    ("coulomb_friction", {"level": 0.02}, 0.02, 0.02),
    ("stribeck_friction", {"level": 0.02, "excess": 0.03, "speed": 0.1}, 0.05, 0.02),
])  # fmt: skip
def test_bristles_slide_at_their_limit_and_creep_back(effect, given, slow, fast, sharpness):
    """Slowly at the breakaway force, fast at the level, both ways; turned back they bear less by their stiffness times the way."""
    law, h, distance = find(effect, "lugre"), 1e-3, 1e-3
    p = parameters(law, damper=0.0, distance=distance, sharpness=sharpness, **given)

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


@pytest.mark.parametrize("sharpness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("effect", ["coulomb_friction", "stribeck_friction"])
def test_a_damper_in_the_bristles_damps_what_sticks_and_not_what_slides(effect, sharpness):
    """A spring beside a damper at small amplitude; its derivative for the implicit step is that of the force."""
    law, h = find(effect, "lugre"), 1e-4
    p = parameters(law, damper=0.3, distance=0.1, level=0.02, sharpness=sharpness)
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
            law.law(Joint(0.0, v + d, 0.0, 1.0, 1.0, 0.0, h, 9.0), p | {"level": np.float64(0.0)}, (0.4, 0.4))[0] for d in (1e-6, -1e-6)
        )
        slope = -(float(ahead.force) - float(near.force)) / 2e-6
        assert float(near.damping) == pytest.approx(slope, rel=1e-3)


def test_quadratic_damping_decays_as_a_hyperbola():
    """1/A grows by 8 c / (3 m) a turn."""
    tops, _ = free_decay("quadratic_damping", "square", 8, coefficient=0.01)
    assert np.diff(1.0 / tops) == pytest.approx(np.full(8, 8 * 0.01 / 3), rel=0.02)


@pytest.mark.parametrize("cubic", [0.02, -0.02])
def test_a_cubic_spring_shifts_the_resonance_with_the_amplitude(cubic):
    """By 3/8 k3 A^2 / k of it, against the linear spring with the same steps."""
    (_, linear), (_, hard) = (free_decay("cubic_stiffness", "cubic", 10, cubic=x) for x in (0.0, cubic))
    assert hard / linear - 1.0 == pytest.approx(3 / 8 * cubic, rel=0.02)


def driven(effect: str, form: str, omega: float, view, **given: float) -> complex:
    """Answer of a drive or sensor law to sin(omega t) in its steady state, relative to it."""
    law = find(effect, form)
    p, z, h = parameters(law, **given), (0.0,) * law.states, 2 * pi / omega / 400
    total = 0.0j
    for k in range(2400):
        signal = sin(omega * k * h)
        y, z = law.law(view(signal, h), p, z)
        if k >= 2000:
            total += float(y) * (sin(omega * k * h) + 1j * cos(omega * k * h)) * 2 / 400
    return total


@pytest.mark.parametrize(("part", "view"), [("drive", lambda u, h: Input(u, (u,), 0, 0.0, h)), ("sensor", lambda y, h: Signal(y, h))])
def test_delay_turns_the_phase_alone_and_lag_loses_gain(part, view):
    delayed = driven(*{"drive": ("drive_delay", "pade"), "sensor": ("sensor_latency", "pade")}[part], 1.0, view, delay=0.5)
    assert abs(delayed) == pytest.approx(1.0, abs=2e-3)
    assert np.angle(delayed) == pytest.approx(-0.5, abs=0.01)
    lagged = driven(f"{part}_lag", "first_order", 1.0, view, time=0.5)
    assert abs(lagged) == pytest.approx(1 / np.sqrt(1.25), rel=0.01)
    assert np.angle(lagged) == pytest.approx(-atan(0.5), rel=0.02)


def modulus(effect: str, form: str, omega: float, **given: float) -> complex:
    """Complex stiffness of a law whose joint moves as sin(omega t)."""
    law = find(effect, form)
    p, z, h = parameters(law, **given), (0.0,) * law.states, 2 * pi / omega / 200
    total, turns = 0.0j, max(3, round(20 * given.get("long", given.get("time")) * omega / (2 * pi)))
    for k in range(200 * turns):
        phase = omega * k * h
        push, z = law.law(Joint(sin(phase), omega * cos(phase), 0.0, 1.0, 1.0, 0.0, h, 9.0), p, z)
        if k >= 200 * (turns - 1):
            total -= float(push.force) * (sin(phase) + 1j * cos(phase)) * 2 / 200
    return total


def test_structural_damping_loses_the_same_at_every_frequency():
    losses = [modulus("structural_damping", "ladder", omega, loss=0.1, time=1.0).imag for omega in (0.2, 0.5, 1.0, 2.0, 5.0)]
    assert losses == pytest.approx([0.1] * 5, rel=0.06)


def test_a_relaxing_spring_has_the_modulus_of_a_maxwell_element():
    for omega in (0.3, 1.0, 3.0):
        found, exact = modulus("viscoelasticity", "maxwell", omega, stiffness=0.2, time=1.0), 0.2 * omega * 1j / (1 + omega * 1j)
        assert abs(found - exact) < 0.02 * abs(exact)


def test_two_relaxing_springs_have_the_modulus_of_a_prony_series():
    for omega in (0.05, 0.3, 2.0):
        found = modulus("viscoelasticity", "two", omega, fast=0.2, slow=0.1, short=1.0, long=20.0)
        exact = 0.2 * omega * 1j / (1 + omega * 1j) + 0.1 * 20.0 * omega * 1j / (1 + 20.0 * omega * 1j)
        assert abs(found - exact) < 0.02 * abs(exact)


def test_creep_in_decades_is_a_sum_of_elements():
    """A step's answer, against exponentials; with equal sizes it is the logarithmic one."""
    free, equal = find("piezo_creep", "decades"), find("piezo_creep", "logarithmic")
    sizes, given = (0.1, 0.05, 0.0, 0.2), {"time": 0.5}
    z, same, u = (0.0,) * 4, (0.0,) * 4, Input(1.0, (1.0,), 0, 0.0, 0.005)
    for _ in range(2000):
        y, z = free.law(u, given | {f"size{k + 1}": x for k, x in enumerate(sizes)}, z)
        one, same = equal.law(u, given | {"size": 0.1}, same)
    assert y == pytest.approx(1.0 + sum(x * (1.0 - exp(-10.0 / (0.5 * 10.0**k))) for k, x in enumerate(sizes)), rel=2e-3)
    assert one == pytest.approx(1.0 + 0.1 * sum(1.0 - exp(-10.0 / (0.5 * 10.0**k)) for k in range(4)), rel=2e-3)


@pytest.mark.parametrize(("form", "given"), [("bouc_wen", {"size": 0.3, "width": 0.5}), ("plays", {"weight2": 0.3, "width": 1.0})])
def test_the_loop_of_hysteresis_does_not_depend_on_the_rate(form, given):
    law = find("piezo_hysteresis", form)

    def area(steps: int) -> float:
        """Of the last of three triangles of height 1."""
        u = np.interp(np.arange(3 * steps) / steps * 4, np.arange(13), [0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1, 0])
        z, y = (0.0,) * law.states, []
        for x in u:
            out, z = law.law(Input(x, (x,), 0, 0.0, 1.0), parameters(law, **given), z)
            y.append(float(out))
        return abs(np.trapezoid(y[2 * steps :], u[2 * steps :]))

    slow, fast = area(4000), area(1000)
    assert slow > 0.05
    assert fast == pytest.approx(slow, rel=0.02)


def test_hysteresis_lags_by_its_width():
    """u - size width (1 - exp(-u / width)) on the way up from nothing."""
    law, z, given = find("piezo_hysteresis", "bouc_wen"), (0.0, 0.0), {"size": 0.3, "width": 0.5}
    for u in np.linspace(0.0, 2.0, 201)[1:]:
        y, z = law.law(Input(u, (u,), 0, 0.0, 1.0), parameters(law, **given), z)
        assert y == pytest.approx(u - 0.3 * 0.5 * (1.0 - exp(-u / 0.5)), abs=1e-5)


@pytest.mark.parametrize(("form", "given"), [("polynomial", {"curvature": -3.0}), ("local", {"extra": -3.0, "width": 5.0})])
def test_damping_that_depends_on_the_angle_leaves_none_rather_than_drive(form, given):
    law = find("configuration_dependent_damping", form)
    push, _ = law.law(Joint(1.0, 2.0, 0.0, 1.0, 1.0, 0.0, H, 0.4), parameters(law, **given), ())
    assert push.damping == -0.4 and push.force == 0.4 * 2.0


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


def test_creep_follows_a_step_with_its_time():
    law, z = find("piezo_creep", "kelvin_voigt"), (0.0,)
    for _ in range(1000):
        y, z = law.law(Input(1.0, (1.0,), 0, 0.0, 0.01), parameters(law, size=0.2, time=10.0), z)
    assert y == pytest.approx(1 + 0.2 * (1 - exp(-1)), rel=1e-3)


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


def test_a_coarse_sensor_knows_multiples_only():
    law = find("sensor_quantisation")
    found = [float(law.law(Signal(y, H), {"step": 0.1, "offset": 0.0}, ())[0]) for y in (0.04, 0.06, -0.26)]
    assert found == pytest.approx([0.0, 0.1, -0.3])
    found = [float(law.law(Signal(y, H), {"step": 0.1, "offset": 0.02}, ())[0]) for y in (0.04, 0.08, -0.26)]
    assert found == pytest.approx([0.02, 0.12, -0.28])  # multiples counted from where it reads as it is


def test_a_counter_moves_on_late_whichever_way_it_is_turned():
    law, z, given = find("sensor_quantisation", "hysteresis"), (0.0,), {"step": 0.1, "offset": 0.0, "stick": 0.2}
    up, down, read = np.linspace(0.0, 0.4, 401), np.linspace(0.4, 0.0, 401), {}
    for way, angles in (("up", up), ("down", down)):
        found = []
        for y in angles:
            out, z = law.law(Signal(float(y), H), given, z)
            found.append(float(out))
        steps = np.flatnonzero(np.abs(np.diff(found)) > 0.05)
        read[way] = angles[steps]
    assert read["up"] == pytest.approx([0.07, 0.17, 0.27, 0.37], abs=2e-3)  # half a step and 0.2 of one
    assert read["down"] == pytest.approx([0.33, 0.23, 0.13, 0.03], abs=2e-3)


def test_a_calibration_curve_can_be_any_smooth_one():
    """Nine nodes follow an eccentric disc with a wave in 1.2 of the usual angle to 4 % of its error."""
    law = find("sensor_nonlinearity", "curve")
    y = np.linspace(-1.6, 1.6, 400)
    wanted = 0.05 * (np.sin(2 * np.pi * y / 1.7 + 0.4) - np.sin(0.4))
    names = [p.name for p in law.sizes]
    columns = [law.law(Signal(y, H), dict.fromkeys(names, 0.0) | {name: 1.0, "step": 0.55}, ())[0] - y for name in names]
    weights, *_ = np.linalg.lstsq(np.column_stack(columns), wanted, rcond=None)
    read, _ = law.law(Signal(y, H), dict(zip(names, weights, strict=True)) | {"step": 0.55}, ())
    assert np.sqrt(np.mean((read - y - wanted) ** 2)) < 0.04 * np.sqrt(np.mean(wanted**2))


def test_a_cascade_is_as_late_as_a_mean_and_loses_as_much():
    """Against the transfer function of a mean over twice the time, up to where that has lost a tenth."""
    law, time, step = find("sensor_lag", "cascade"), 0.5, 0.01
    for omega in (0.3, 0.8, 1.5):
        z, response, n = (0.0,) * 3, 0.0, int(20 * 2 * np.pi / omega / step)
        for k in range(n):
            phase = np.exp(1j * omega * k * step)
            out, z = law.law(Signal(phase.real, step), {"time": time}, z)
            response += 2.0 * out * phase.conjugate() / (0.5 * n) if k >= n // 2 else 0.0
        mean = np.exp(-1j * omega * time) * np.sin(omega * time) / (omega * time)
        assert abs(response - mean) < 0.02


def test_a_gain_comes_and_goes_with_its_periods():
    law = find("drive_drift", "waves")
    given = {p.name: 0.0 for p in law.parameters} | {"slow_sine": 0.1, "fast_cosine": 0.2, "period": 40.0, "ratio": 2.5}
    for t in (0.0, 3.0, 17.0, 31.0, 1234.5):
        u, _ = law.law(Input(2.0, (2.0,), 0, t, H), given, ())
        assert u == pytest.approx(2.0 * (1.0 + 0.1 * np.sin(2 * np.pi * t / 40.0) + 0.2 * np.cos(5 * np.pi * t / 40.0)), abs=1e-9)


def pair(q, v=(0.0, 0.0), drive=(0.3, -0.2)) -> Pair:
    return Pair(tuple(q), tuple(v), drive, (1.5, 0.8), (1.0, 1.0), H)


def transmission_energy(q, p) -> float:
    """Springs on the actuators' side and drive, with the map, less the same without it."""
    (s, r), total = q, 0.0
    for i, k in enumerate((1.5, 0.8)):
        powers = ((2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
        travel = q[i] + sum(p[f"a{i + 1}_{a}{b}"] * s**a * r**b for a, b in powers)
        spring = p[f"share{i + 1}"] * k
        total += 0.5 * spring * (travel**2 - q[i] ** 2) - (0.3, -0.2)[i] * (travel - q[i])
    return total


def stiffness_energy(q, p) -> float:
    return sum(value * q[0] ** int(name[1]) * q[1] ** int(name[2]) for name, value in p.items())


@pytest.mark.parametrize(
    ("effect", "form", "energy"),
    [("configuration_dependent_transmission", "map", transmission_energy),
     ("configuration_dependent_stiffness", "potential", stiffness_energy)],
)  # fmt: skip
def test_springs_are_gradients(effect, form, energy, rng):
    law = find(effect, form)
    p = {x.name: rng.uniform(0.1, 0.6) for x in law.parameters}
    q, eps = np.array([0.3, -0.2]), 1e-5
    push, _ = law.law(pair(q), p, ())
    for i, step in enumerate(np.eye(2) * eps):
        assert push.force[i] == pytest.approx(-(energy(q + step, p) - energy(q - step, p)) / (2 * eps), rel=1e-6)


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


def test_a_payload_adds_up_as_bodies_do(rng):
    law = find("added_mass")
    com, at, spin = rng.normal(0, 2, 3), rng.normal(0, 5, 3), rng.normal(0, 1, 3)
    before = Chassis(1.2, tuple(com), (10.0, 20.0, 25.0, 1.0, -2.0, 0.5), (0.0, 0.0, -9.8e-3))
    after, _ = law.law(before, {"mass": 0.5, "x": at[0], "y": at[1], "z": at[2]}, ())
    assert after.mass == pytest.approx(1.7)
    assert after.com == pytest.approx((1.2 * com + 0.5 * at) / 1.7)

    def energy(chassis) -> float:
        """Of a turn about the origin."""
        xx, yy, zz, xy, xz, yz = chassis.inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return 0.5 * spin @ tensor @ spin + 0.5 * chassis.mass * np.sum(np.cross(spin, chassis.com) ** 2)

    assert energy(after) == pytest.approx(energy(before) + 0.25 * np.sum(np.cross(spin, at) ** 2))


def test_slope_and_air():
    roll = find("gravity_tilt").law(Chassis(1.0, (), (), (0.0, 0.0, -1.0)), {"roll": 0.1, "pitch": 0.0}, ())[0].gravity
    assert roll == pytest.approx((0.0, -sin(0.1), -cos(0.1)))  # left side up: it rolls to the right
    pitch = find("gravity_tilt").law(Chassis(1.0, (), (), (0.0, 0.0, -1.0)), {"roll": 0.0, "pitch": 0.1}, ())[0].gravity
    assert pitch == pytest.approx((sin(0.1), 0.0, -cos(0.1)))  # nose down: forward
    drag = find("air_drag").law(Motion((0.0, 0.0, 0.0), (3.0, 0.0, 4.0)), {"coefficient": 0.1}, ())[0]
    assert drag == pytest.approx((-1.5, 0.0, -2.0))


@pytest.mark.parametrize(("name", "form"), [(name, form) for name, effect in library().items() for form in effect.forms
                                           if form.acts in ("drive", "force", "sense")])  # fmt: skip
def test_no_size_no_effect(name, form, rng):
    """Exactly: not a bit of signal or force, over fifty steps of noise."""
    p, z = parameters(form), (0.0,) * form.states
    for q, v in rng.normal(0, 1, (50, 2)):
        views = {"drive": Input(q, (q, v), 0, 1.0, H), "force": Joint(q, v, 0.3, 1.0, 1.0, 0.0, H, 9.0), "sense": Signal(q, H)}
        with np.errstate(divide="ignore"):
            answer, z = form.law(views[form.acts], p, z)
        if isinstance(answer, Push):
            assert (answer.force, answer.stiffness, answer.damping, answer.mass, answer.slip) == (0.0,) * 5
        else:
            assert answer == q


@given(st.floats(-20.0, 20.0))
def test_a_table_goes_on_as_at_its_edge(x):
    weights = np.array(hats(x))
    assert weights.sum() == pytest.approx(1.0)
    assert np.array_equal(weights, hats(np.clip(x, -2.0, 2.0)))
    assert weights @ np.arange(-2.0, 3.0) == pytest.approx(np.clip(x, -2.0, 2.0), abs=1e-12)  # straight lines are exact
