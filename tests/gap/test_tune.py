"""How a model is re-tuned: free runs where they stay near what was measured, short ones where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfilt

from hamr_dynamics.machine import linear_machine
from hamr_gap.answers.found import find
from hamr_gap.data.record import Record
from hamr_gap.judging.analyse import analyse
from hamr_gap.naming.prepare import prepare
from hamr_gap.showing.show import show

SLIDE = linear_machine("slide", inertia=1.0, stiffness=20.0, damping=6.0, joint="slide")


def sticking(friction: float, share: float = 0.0) -> Record:
    """80 s of a slide on a spring under slow noise, with N of dry friction, and a share of the drive, that stop it exactly; nobody says
    where it began."""
    step, fine, n, q, v = 0.01, 20, 8000, 0.2, 0.0
    random = np.random.default_rng(1)
    drive = sosfilt(butter(3, 0.7, fs=1.0 / step, output="sos"), random.standard_normal(n))
    drive, seen, h = 6.0 * drive / drive.std(), np.empty(n), step / fine
    for i, u in enumerate(drive):
        seen[i] = q
        for _ in range(fine):
            v += h * (u - 20.0 * q - 6.0 * v)
            v = np.sign(v) * max(abs(v) - h * (friction + share * abs(u)), 0.0)
            q += h * v
    read = seen + random.normal(0.0, 1e-3 * np.ptp(seen), n)
    return Record(drive[:, None], read[:, None], step, ("slide",), held=True, rest=False)


@pytest.mark.parametrize(("friction", "astray"), [(2.0, False), (4.0, True)])
def test_free_runs_that_go_astray_give_way_to_short_ones(friction, astray):
    """A slide that forgets its start, until it sticks where the model lets it return; either way friction and its size are found."""
    record = sticking(friction)
    short = prepare(SLIDE, record)
    assert short.shortened == astray == bool(short.weighed.model.starts)
    verdict = analyse(SLIDE, record).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert effect.effect == "coulomb_friction"
    assert effect.parameters["level"]["slide"].value == pytest.approx(friction, rel=0.02)


def test_friction_that_grows_with_the_load_is_told_from_what_does_not():
    """As of a geared servo: neither size alone leaves so little."""
    verdict = analyse(SLIDE, sticking(0.8, share=0.2)).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert (effect.effect, effect.form) == ("coulomb_friction", "loaded")
    sizes = {name: effect.parameters[name]["slide"].value for name in ("level", "share")}
    assert sizes == {"level": pytest.approx(0.8, rel=0.05), "share": pytest.approx(0.2, rel=0.05)}


def test_what_stays_in_short_runs_is_shown_in_them(monkeypatch):
    monkeypatch.setattr("hamr_gap.naming.searched._mended", lambda *_: None)
    record = sticking(4.0)
    found = find(SLIDE, record)
    assert found.simulation["piece"] > 0.0
    shown, _ = show(SLIDE, found, record, fresh=False)
    assert shown["over_floor"]["retuned"] == pytest.approx(found.verdict["gap"]["retuned"], rel=0.5)  # in free runs, 2.2 times
    assert list(shown["horizons"]) == ["0.08 s", "0.5 s"] and np.isfinite([list(h.values()) for h in shown["horizons"].values()]).all()


def looping(seconds: float) -> Record:
    """The benchmark of hysteresis (Noel, Schoukens 2016), by small steps: 2 kg, 10 N s/m, 5e4 N/m, alpha 5e4, beta 1e3, gamma 0.8,
    delta -1.1, under 50 N of noise to 120 Hz."""
    fs, fine, random = 750.0, 40, np.random.default_rng(1)
    n, y, v, z = int(seconds * fs), 0.0, 0.0, 0.0
    coarse = sosfilt(butter(4, 120.0, fs=fs, output="sos"), random.standard_normal(n))
    drive, h, seen = 50.0 * coarse / coarse.std(), 1.0 / fs / fine, np.empty(n)
    between = CubicSpline(np.arange(n), drive)((np.arange(n * fine) + 0.5) / fine).reshape(n, fine)
    for i in range(n):
        seen[i] = y
        for u in between[i]:
            v += h * (u - 5e4 * y - 10.0 * v - z) / 2.0
            z += h * (5e4 * v - 1e3 * (0.8 * abs(v) * z - 1.1 * v * abs(z)))
            y += h * v
    read = seen + random.normal(0.0, 4e-6, n)
    return Record(drive[:, None], read[:, None], 1.0 / fs, ("mass",), rest=False)


def test_a_loop_is_found_through_short_runs_and_measured_in_free_ones():
    """Runs that start anew forget the loop; that it mends free ones is found out, and its sizes there are those of the benchmark."""
    mass = linear_machine("mass", inertia=2.0, damping=12.0, stiffness=9e4, joint="mass")
    verdict = (found := analyse(mass, record := looping(12.0))).verdict
    assert not found.prepared.shortened and prepare(mass, record).shortened
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert effect.effect == "spring_hysteresis"
    sizes = {name: x["mass"].value for name, x in effect.parameters.items()}
    assert sizes == pytest.approx({"size": 5e4 / 800.0, "distance": 1.0 / 800.0, "skew": -1.1 / 0.8}, rel=0.1)
