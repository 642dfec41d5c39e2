"""Hidden laws one by one, driven along prescribed paths, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from hidden_gap.laws.law import ARMATURE, LAWS, SIZE, TAU, Q, U, V, address
from hidden_gap.laws.sensor import sensed
from hidden_gap.loop import _call_law

DT = 0.025


@njit
def _drive(law, joints, dt, q, v, u, p, s, states, out):
    w = np.zeros(out.shape[1])
    for k in range(len(q)):
        w[:] = 0.0
        w[Q : Q + 2], w[V : V + 2], w[U : U + 2] = q[k], v[k], u[k]
        for n in range(len(joints)):
            _call_law(law, joints[n], k * dt, dt, w.ctypes.data, p.ctypes.data, s.ctypes.data + 8 * states * n)
        out[k] = w


def drive(name: str, parameters: dict, *, q=0.0, v=0.0, u=0.0, joints=(0,), dt: float = DT) -> np.ndarray:
    """(n, SIZE) workspace after the law, along paths (n,) of joint 0 or (n, 2)."""
    law = LAWS[name]
    parameters = {key: low if low > 0 else 0.0 for key, (low, _) in law.ranges.items()} | parameters
    n = max(np.size(x) if np.ndim(x) < 2 else len(x) for x in (q, v, u))
    paths = [
        np.ascontiguousarray(np.broadcast_to(x if np.ndim(x) == 2 else np.reshape(x, (-1, 1)) * [1.0, 0.0], (n, 2))) for x in (q, v, u)
    ]
    states, out = law.count(parameters, dt), np.zeros((n, SIZE))
    numbers = np.append(law.numbers(parameters, dt), 0.0)
    _drive(address(name), np.array(joints), dt, *paths, numbers, np.zeros(2 * states + 1), states, out)
    return out


@pytest.mark.parametrize("name", ["lugre", "elasto_plastic"])
@pytest.mark.parametrize("rate", [0.004, -0.02])
def test_sliding_bristles_give_the_coulomb_force(name, rate):
    torque = drive(name, {"force": 0.01}, v=np.full(20_000, rate), dt=0.01)[:, TAU]
    assert torque[-1] == pytest.approx(-0.01 * np.sign(rate), rel=1e-3)


@pytest.mark.parametrize("name", ["lugre", "elasto_plastic", "lugre_stribeck", "rational_stribeck"])
def test_a_bristle_holds_as_a_spring_before_it_slides(name):
    settled = drive(name, {"force": 0.01, "presliding": 1e-3}, v=np.r_[np.full(100, 2e-5), np.zeros(3)], dt=0.01)[-1, TAU]
    assert settled == pytest.approx(-0.01 / 1e-3 * 2e-5, rel=0.03)  # 100 steps of 0.01 ms at 2e-5 rad/ms


@pytest.mark.parametrize(("name", "shape"), [("lugre_stribeck", {"power": 2.0}), ("rational_stribeck", {})])
def test_friction_falls_from_breakaway_to_sliding(name, shape):
    force = [
        drive(name, {"force": 0.01, "excess": 1.0, "rate": 0.005, **shape}, v=np.full(20_000, rate), dt=0.01)[-1, TAU]
        for rate in (3e-5, 0.5)
    ]
    assert force == pytest.approx([-0.02, -0.01], rel=5e-3)


@given(st.floats(0.05, 5.0))
def test_the_lag_is_the_exact_exponential(tau):
    mean = drive("exact_lag", {"tau": tau}, u=np.ones(400))[:, U]
    start = np.arange(400) * DT
    assert mean == pytest.approx(1 - tau / DT * (np.exp(-start / tau) - np.exp(-(start + DT) / tau)), abs=1e-9)


@given(st.floats(0.02, 4.0))
def test_the_delay_is_exact_between_the_steps(tau):
    n = 400
    ramp = np.arange(n) + 0.5  # mean over each step of a ramp by 1 per step
    late = drive("ring_buffer", {"tau": tau}, u=ramp)[:, U]
    assert late[200:] == pytest.approx(ramp[200:] - tau / DT, abs=1e-9)


def _modulus(name: str, parameters: dict, hertz: float) -> complex:
    """Stiffness and loss at a frequency, by demodulating the torque of a sinusoid."""
    n = round(1e3 / hertz / DT) * 8
    t = np.arange(n) * DT
    torque = -drive(name, parameters, q=np.sin(2e-3 * np.pi * hertz * t))[:, TAU]
    half = slice(n // 2, None)
    return 2j * np.mean(torque[half] * np.exp(-2e-3j * np.pi * hertz * t[half]))


def test_structural_loss_is_flat_over_two_decades():
    loss = [_modulus("relaxation_ladder", {"loss": 0.1}, hertz).imag for hertz in (1.0, 3.0, 10.0, 30.0, 100.0)]
    assert loss == pytest.approx([0.1] * 5, rel=0.08)


def test_fractional_loss_grows_as_its_power():
    loss = [_modulus("fractional", {"loss": 0.1, "exponent": 0.2}, hertz).imag for hertz in (4.0, 40.0)]
    assert loss[1] / loss[0] == pytest.approx(10**0.2, rel=0.05)


def test_the_standard_solid_has_its_modulus():
    x = 2e-3j * np.pi * 30.0 * 5.0
    assert _modulus("standard_solid", {"stiffness": 0.2, "tau": 5.0}, 30.0) == pytest.approx(0.2 * x / (1 + x), rel=0.01)


def test_sliders_that_yield_one_by_one_have_masings_loops():
    """On the way back the curve is the first one twice as large (Masing 1926), and a minor loop closes where it began."""
    out, back = np.linspace(0, 0.3, 301), np.linspace(0.3, -0.3, 601)
    path = np.concatenate([out, back[:301], back[300:200:-1], back[200:]])  # a minor loop on the way back
    torque = -drive("iwan", {"stiffness": 2.0, "reach": 0.4}, q=path)[:, TAU]
    first, down = torque[:301], np.concatenate([torque[301:602], torque[803:]])
    assert first[-1] == pytest.approx(2.0 * (0.3 - 0.3**2 / (2 * 0.4)), rel=0.01)  # of sliders without number
    assert down == pytest.approx(first[-1] - 2.0 * np.interp(0.5 * (0.3 - back), out, first), abs=1e-12)


@pytest.mark.parametrize(("power", "out", "back"), [  # exponents whose curves are known
    (2.0, np.tanh(1.6), np.arctan(2.0 * np.tanh(1.6)) / 2.0),
    (1.0, 1.0 - np.exp(-1.6), np.log1p(4.0 * (1.0 - np.exp(-1.6))) / 4.0),
])  # fmt: skip
def test_bouc_and_wens_loop_follows_its_curves(power, out, back):
    v, n, p = 0.004, 4000, {"stiffness": 2.0, "reach": 0.1, "back": 4.0, "power": power}  # 0.16 rad out, and back
    z = drive("bouc_wen_power", p, v=np.r_[np.full(n, v), np.full(n, -v)], dt=0.01)[:, TAU] / (-2.0 * 0.1)
    assert z[n - 1] == pytest.approx(out, rel=1e-3)
    assert np.flatnonzero(z[n:] < 0.0)[0] * 0.01 * v / 0.1 == pytest.approx(back, rel=2e-3)


@pytest.mark.parametrize("hertz", [5.0, 50.0])
def test_play_loops_have_their_area_at_any_rate(hertz):
    n = round(1e3 / hertz / DT)
    u = 80.0 * np.sin(2 * np.pi * np.arange(3 * n) / n)
    share = {"loop": 0.3, "reach": 60.0, "steepness": 1.0}
    _, *numbers = LAWS["play_sum"].numbers(share, DT)
    radius, weight = np.split(np.array(numbers), 2)
    out, last = drive("play_sum", share, u=u)[:, U], slice(2 * n, None)
    area = abs(np.trapezoid(np.r_[out[last], out[2 * n]], np.r_[u[last], u[2 * n]]))
    assert area == pytest.approx(0.3 * np.sum(weight * 4 * radius * (80.0 - radius)), rel=2e-3)


def test_coleman_hodgdon_asks_for_the_way_not_the_time():
    slow = 60.0 * np.sin(np.linspace(0, 20, 40_001))
    parameters = {"loop": 0.3, "scale": 40.0}
    out = drive("coleman_hodgdon", parameters, u=slow)[:, U]
    fast = drive("coleman_hodgdon", parameters, u=slow[::40])[:, U]
    assert fast == pytest.approx(out[::40], abs=0.02)
    assert np.ptp((out - slow)[np.abs(slow) < 0.02]) > 1.0  # a loop: two values at the same voltage


def test_creep_grows_by_the_same_in_every_decade():
    u = np.ones(500_000)  # 12.5 s
    out = drive("log_creep", {"per_decade": 0.1}, u=u)[:, U]
    at = [out[round(t / DT)] for t in (125.0, 1250.0, 12_400.0)]
    assert np.diff(at) == pytest.approx([0.1, 0.1], rel=0.1)


@pytest.mark.parametrize("name", ["smooth_square", "turbulent"])
def test_drag_is_quadratic_above_its_core(name):
    torque = drive(name, {"drag": 2.0}, v=np.array([0.05, -0.1]))[:, TAU]
    assert torque == pytest.approx([-2.0 * 0.0025, 2.0 * 0.01], rel=0.01)


@pytest.mark.parametrize("name", [law.name for law in LAWS.values() if law.family in ("quadratic_damping", "end_stop")])
@given(q=st.floats(-0.6, 0.6), v=st.floats(-0.1, 0.1))
def test_passive_laws_never_push_along(name, q, v):
    torque = drive(name, {"depth": 0.5} if "depth" in LAWS[name].ranges else {}, q=np.array([q]), v=np.array([v]))[0, TAU]
    assert torque * (q if "stop" in LAWS[name].family else v) <= 0.0


def test_a_stop_is_felt_only_inside_its_depth():
    torque = drive("hunt_crossley", {"depth": 0.5, "stiffness": 10.0}, q=np.array([0.27, 0.275, 0.375]))[:, TAU]
    assert torque == pytest.approx([0.0, 0.0, -10.0 * 0.1**1.5])


@pytest.mark.parametrize(("name", "size"), [("slanted_valley", {"depth": 0.5, "mix": 0.7, "centre": 0.1}), ("three_waves", {"pull": 1.0})])
def test_potentials_give_back_the_work_on_a_closed_path(name, size):
    turn = np.linspace(0, 2 * np.pi, 2001)
    path = np.stack([0.3 * np.cos(turn), 0.2 * np.sin(turn) + 0.1 * np.cos(2 * turn)], axis=1)
    torque = drive(name, size, q=path, joints=(0, 1))[:, TAU : TAU + 2]
    assert abs(np.sum(np.trapezoid(torque.T, path.T))) < 1e-6
    assert np.abs(torque).max() > 0.01


@pytest.mark.parametrize("name", ["sliding_mass", "pirouette"])
def test_moving_masses_have_the_torques_of_their_kinetic_energy(name):
    """Lagrange: torque = dT/dq - (dJ/dt) v, with T and J from the added inertia alone."""
    parameters, joints, h = {"mass": 1.0, "phase": 0.3, "host": 1.0}, (0, 1) if name == "pirouette" else (0,), 1e-5
    q, v = np.array([0.2, -0.1]), np.array([0.03, 0.05])

    def inertia(at):
        return drive(name, parameters, q=at[None], v=v[None], joints=joints)[0, ARMATURE : ARMATURE + 2]

    slope = np.array([(inertia(q + h * e) - inertia(q - h * e)) / (2 * h) for e in np.eye(2)])  # slope[k, j] = dJ_j / dq_k
    expected = 0.5 * slope @ v**2 - (v @ slope) * v
    torque = drive(name, parameters, q=q[None], v=v[None], joints=joints)[0, TAU : TAU + 2]
    assert torque == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_felt_rubs_in_its_corner_only_and_against_the_whole_way():
    q, v = np.array([[0.2, -0.3], [0.05, -0.3], [0.2, 0.3], [-0.2, -0.3]]), np.tile([0.3, 0.4], (4, 1))
    torque = drive("felt_corner", {"force": 0.1, "swing": 1.0, "lift": -1.0}, q=q, v=v, joints=(0, 1))[:, TAU : TAU + 2]
    assert torque == pytest.approx(np.array([[-0.06, -0.08], [-0.03, -0.04], [0.0, 0.0], [0.0, 0.0]]), rel=1e-4)


def test_the_gain_lost_in_a_reverse_field_stays_until_a_forward_one():
    n, p = 4000, {"loss": 0.4, "coercive": 20.0, "tau": 5.0}
    u = np.repeat([10.0, -60.0, -10.0, 10.0, 60.0, 10.0], n)
    assert drive("depoling", p, u=u)[n - 1 :: n, U] / u[n - 1 :: n] == pytest.approx([1.0, 0.6, 0.6, 0.6, 1.0, 1.0], abs=1e-6)


def test_the_charge_sparks_once_per_way_however_slowly_it_goes():
    for rate in (0.02, -0.05):
        torque = drive("static_charge", {"torque": 0.1, "way": 0.5}, v=np.full(40_000, rate))[:, TAU]
        assert np.sum(np.diff(torque) < -0.09) == pytest.approx(abs(rate) * 40_000 * DT / 0.5, abs=1.0)
        assert torque.min() >= 0.0 and torque.max() <= 0.1


@pytest.mark.parametrize("tau", [0.5, 1.0])
def test_a_shorted_coil_takes_the_work_of_its_current(tau):
    turn = np.linspace(0, 20 * np.pi, 40_001)  # ten turns of 100 ms: flux = sin(2 x) 0.3^2 / 2
    path = 0.3 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    torque, x = drive("shorted_coil", {"flux": 10.0, "tau": tau}, q=path, joints=(0, 1))[:, TAU : TAU + 2], 2 * 2 * np.pi / 100.0 * tau
    work = np.sum(np.trapezoid(torque[4000:].T, path[4000:].T))
    assert work / 9 == pytest.approx(-2 * np.pi * 10.0 * 0.045**2 * x / (1 + x * x), rel=0.01)


def test_sand_that_was_pushed_away_is_not_met_again_at_once():
    out, p = np.linspace(0.0, 0.3, 1000), {"stiffness": 1.0, "home": 0.1, "push": 1.0, "back": 5000.0, "side": 1.0}
    torque = drive("sand_heap", p, q=np.r_[out, out[::-1], out])[:, TAU]
    first, back, again = np.split(torque, 3)
    assert first[:333].max() == 0.0 and first.min() < -0.01
    assert not back[100:].any() and not again[out < 0.29].any() and again[-1] < 0.0


def test_the_other_joint_pumps_up_what_leaks_away():
    v = np.repeat([[0.0, 0.0], [0.3, 0.02], [0.3, -0.02]], 20_000, axis=0)
    torque = drive("foot_pump", {"torque": 0.1, "leak": 30.0, "side": 1.0}, v=v)[19_999::20_000, TAU]
    assert torque == pytest.approx([0.0, 0.1 * 0.02 * 30.0, 0.0], abs=1e-6)


def test_the_kicker_hits_for_its_time_and_is_deaf_for_a_while():
    q = 0.1 * np.sin(2 * np.pi * np.arange(8000) * DT / 20.0 - 0.5)  # touched every 20 ms
    hit = drive("kicker", {"torque": 0.1, "place": 0.0, "blow": 5.0, "rest": 20.0}, q=q)[:, TAU] == -0.1
    starts = np.flatnonzero(np.diff(hit.astype(int)) > 0) * DT
    assert np.diff(starts) == pytest.approx([40.0] * 4, abs=2 * DT)
    assert hit.sum() * DT == pytest.approx(5.0 * len(starts), abs=len(starts) * 2 * DT)


def test_the_clamp_holds_where_the_other_voltage_found_the_leg():
    q, other = np.array([0.1, 0.2, 0.3, -0.1, 0.0, 0.1]), np.array([0.0, -50.0, 50.0, 50.0, 5.0, 50.0])
    paths = {"q": np.stack([q, q], axis=1), "u": np.stack([0.0 * other, other], axis=1)}
    torque = drive("electric_clamp", {"stiffness": 2.0, "level": 20.0}, **paths)[:, TAU]
    assert torque == pytest.approx([0.0, 0.0, -0.2, 0.6, 0.0, 0.0])


def _sine(hertz: float, *, at: float = 0.0) -> np.ndarray:
    return 0.3 * np.sin(2e-3 * np.pi * hertz * (np.arange(20_000) * 0.05 - at))


def test_late_sensors_show_the_past():
    assert sensed("pipeline", _sine(20.0), {"tau": 1.234})[100:] == pytest.approx(_sine(20.0, at=1.234)[100:], abs=2e-5)


def test_slow_sensors_have_their_transfer_function():
    transfer = 1 / (1 + 2e-3j * np.pi * 20.0 * 2.0)
    seen = sensed("low_pass", _sine(20.0), {"tau": 2.0})
    expected = abs(transfer) * _sine(20.0, at=-np.angle(transfer) / (2e-3 * np.pi * 20.0))
    assert seen[2000:] == pytest.approx(expected[2000:], abs=1e-4)
    mean = np.sinc(2e-3 * 20.0 * 2.0) * _sine(20.0, at=2.0)
    assert sensed("moving_mean", _sine(20.0), {"tau": 2.0})[100:] == pytest.approx(mean[100:], abs=2e-3)


@pytest.mark.parametrize(("name", "most"), [("mid_tread", 0.5), ("counter", 0.8)])
def test_scales_are_off_by_so_many_lines_at_most(name, most):
    parameters = {"line": 0.02, "phase": 0.3} | ({"stick": 0.3} if name == "counter" else {})
    error = sensed(name, _sine(3.0), parameters) - _sine(3.0)
    assert 0.4 * 0.02 < np.abs(error).max() <= most * 0.02 + 1e-12
