"""Drives and sensors against closed forms: what delays, lags, creeps, has loops or steps."""

from __future__ import annotations

from math import atan, exp

import numpy as np
import pytest
from stepped_laws import H, driven, parameters

from hamr_dynamics.effects.law import Input, Signal
from hamr_dynamics.effects.library import find


@pytest.mark.parametrize(("part", "view"), [("drive", lambda u, h: Input(u, (u,), 0, 0.0, h)), ("sensor", lambda y, h: Signal(y, h))])
def test_delay_turns_the_phase_alone_and_lag_loses_gain(part, view):
    delayed = driven(*{"drive": ("drive_delay", "pade"), "sensor": ("sensor_latency", "pade")}[part], 1.0, view, delay=0.5)
    assert abs(delayed) == pytest.approx(1.0, abs=2e-3)
    assert np.angle(delayed) == pytest.approx(-0.5, abs=0.01)
    lagged = driven(f"{part}_lag", "first_order", 1.0, view, time=0.5)
    assert abs(lagged) == pytest.approx(1 / np.sqrt(1.25), rel=0.01)
    assert np.angle(lagged) == pytest.approx(-atan(0.5), rel=0.02)


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


def test_creep_follows_a_step_with_its_time():
    law, z = find("piezo_creep", "kelvin_voigt"), (0.0,)
    for _ in range(1000):
        y, z = law.law(Input(1.0, (1.0,), 0, 0.0, 0.01), parameters(law, size=0.2, time=10.0), z)
    assert y == pytest.approx(1 + 0.2 * (1 - exp(-1)), rel=1e-3)


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


def test_a_gain_comes_and_goes_with_its_periods():
    law = find("drive_drift", "waves")
    given = {p.name: 0.0 for p in law.parameters} | {"slow_sine": 0.1, "fast_cosine": 0.2, "slow_period": 40.0, "fast_period": 16.0}
    for t in (0.0, 3.0, 17.0, 31.0, 1234.5):
        u, _ = law.law(Input(2.0, (2.0,), 0, t, H), given, ())
        assert u == pytest.approx(2.0 * (1.0 + 0.1 * np.sin(2 * np.pi * t / 40.0) + 0.2 * np.cos(5 * np.pi * t / 40.0)), abs=1e-9)


@pytest.mark.parametrize(("change", "gain"), [(0.1, lambda warm: 1.0 + warm), (-0.1, lambda warm: 1.0 / (1.0 + warm))])
def test_a_drive_is_warmed_by_its_own_work(change, gain):
    """Under a sine the heat nears amplitude^2 / 2 with exp(-t / time), and is gone at rest; a gain that falls stays above none."""
    law, z, time = find("drive_drift", "heating"), (0.0,), 50.0
    given, gains, step = {"change": change, "time": time}, [], 0.05
    for k in range(int(8.0 * time / step)):
        t = k * step
        u = 2.0 * np.sin(5.0 * t) if t < 4.0 * time else 1e-6
        out, z = law.law(Input(u, (u,), 0, t, step), given, z)
        gains.append(out / u if u else 1.0)
    warm = gain(0.1 * 2.0 * (1.0 - np.exp(-np.array([1.0, 3.9]))))
    assert [gains[int(x * time / step)] for x in (1.0, 3.9)] == pytest.approx(warm, abs=2e-3)
    left = gain(0.1 * 2.0 * (1.0 - np.exp(-4.0)) * np.exp(-3.9))
    assert gains[int(7.9 * time / step)] == pytest.approx(left, abs=2e-3)


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
