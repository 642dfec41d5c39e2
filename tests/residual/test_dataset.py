"""Smoothing and cutting of recordings, against motion known in closed form."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from residual_samples import noise_run, recording

from hamr_description.errors import BagError
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ
from hamr_dynamics.leg_step import LANES, LegStep
from hamr_sim_residual import dataset
from hamr_sim_residual.residual_plant import torque_driven

W = 2 * np.pi * 0.08  # rad/ms: 80 Hz


def waves(*, hz: float = SERVO_HZ, noise: float = 0.0, seconds: float = 1.0, environment: str = "suspended", cut=None):
    """All joints on a sine of 0.2 rad, drives on a slow cosine."""
    t = np.arange(int(seconds * hz)) / hz
    angles = 0.2 * np.sin(W * 1e3 * t)[:, None] * np.ones(8) + noise * np.random.default_rng(0).standard_normal((len(t), 8))
    volts = value("actuator.neutral_voltage") + 30 * np.cos(2 * np.pi * 20 * t)[:, None] * np.ones(8)
    whole = [slice(0, len(t))]
    return SimpleNamespace(
        time=t, angles=angles, voltages=volts, deflections=np.zeros_like(angles), rates=None, environment=environment, sample_hz=float(hz),
        pieces=cut or whole,
    )  # fmt: skip


def truth(n: int):
    t = np.arange(n) / SERVO_HZ * 1e3
    sign = dataset.SIGNS
    return 0.2 * np.sin(W * t)[None, :, None] * sign, 0.2 * W * np.cos(W * t)[None, :, None] * sign


@pytest.mark.parametrize(("hz", "tolerance"), [(SERVO_HZ, 1e-7), (SERVO_HZ // 5, 3e-4)])
def test_rates_of_clean_angles(hz, tolerance):
    (part,) = dataset.stretches(waves(hz=hz))
    q, v = truth(len(part))
    assert part.half_width == dataset.HALF_WIDTHS[0]
    np.testing.assert_allclose(part.q, q, rtol=0, atol=tolerance * 0.2)
    np.testing.assert_allclose(part.v, v, rtol=0, atol=tolerance * 0.2 * W * 10)
    np.testing.assert_allclose(part.angles[:, :: SERVO_HZ // hz], dataset.by_leg(waves(hz=hz).angles, dataset.SIGNS), atol=1e-15)
    volts = 30 * np.cos(2 * np.pi * 20 * np.arange(len(part)) / SERVO_HZ)
    np.testing.assert_allclose(np.abs(part.drive[0, :, 0]), np.abs(volts), atol=0.02)


def test_window_widens_with_noise_and_rates_stay_good():
    clean, noisy, very = (dataset.stretches(waves(noise=x))[0] for x in (0.0, 1e-3, 1e-2))
    assert clean.half_width < noisy.half_width < very.half_width
    rate = truth(len(noisy))[1]
    plain = np.gradient(dataset.by_leg(waves(noise=1e-3).angles, dataset.SIGNS), 1e3 / SERVO_HZ, axis=1)
    assert np.std(noisy.v - rate) < 0.02 * np.std(rate) < np.std(plain - rate)


def test_declared_rates_are_taken_as_they_are():
    sample = waves()
    sample.rates = np.full_like(sample.angles, 7.0)
    (part,) = dataset.stretches(sample)
    np.testing.assert_allclose(np.abs(part.v), 7e-3)


def test_gaps_and_stops_cut_windows():
    whole = waves(seconds=0.5)
    halves = waves(seconds=0.5, cut=[slice(0, 5000), slice(5040, 10_000)])
    step = LegStep(torque_driven())
    assert [len(part) for part in dataset.stretches(halves)] == [5000, 4960]
    touched = waves(seconds=0.5)
    touched.deflections[4000, 5] = 1e-3 * value("actuator.stop")  # fr_lift: the third leg
    (part,) = dataset.stretches(touched)
    assert part.inside.sum(axis=1).tolist() == [10_000, 10_000, 10_000 - (2 * part.half_width + 3), 10_000]
    counts = [len(dataset.windows(dataset.stretches(x), 160, step)) * LANES for x in (whole, touched)]
    assert counts[0] == 4 * ((10_000 - 1) // 160) // LANES * LANES
    assert counts[1] <= counts[0]


def test_windows_hold_consecutive_samples():
    parts = dataset.stretches(recording(noise_run(3, 0.6, 30.0)))
    data = dataset.windows(parts, 40, LegStep(torque_driven()))
    found = set()
    for block in range(len(data)):
        state, goal = data.state0[block].reshape(6, LANES), data.goal[block].reshape(40, 2, LANES)
        for lane in range(LANES):
            ((leg, k),) = np.argwhere((parts[0].q == state[:2, lane]).all(axis=-1))
            np.testing.assert_array_equal(state[2:4, lane], parts[0].v[leg, k])
            np.testing.assert_array_equal(goal[:, :, lane], parts[0].angles[leg, k + 1 : k + 41])
            found.add((int(leg), int(k)))
    assert len(found) == len(data) * LANES
    assert {leg for leg, _ in found} == {0, 1, 2, 3}
    assert all((k - 1) % 40 == 0 for _, k in found)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"environment": "ground"}, "suspended"),
        ({"hz": 3000}, "multiple"),
        ({"seconds": 3e-4}, "stretch"),
    ],
)
def test_recordings_that_do_not_fit(change, word):
    with pytest.raises(BagError, match=word):
        dataset.stretches(waves(**change))


def test_too_short_for_windows():
    with pytest.raises(BagError, match="record longer"):
        dataset.windows(dataset.stretches(waves(seconds=0.02)), 640, LegStep(torque_driven()))


def test_digest_depends_on_what_is_read_alone():
    run = noise_run(0, 0.6)
    plain, scrambled = recording(run), recording(run, torque=np.ones(run.q.shape), acceleration=np.ones(run.q.shape))
    assert dataset.digest([plain]) == dataset.digest([scrambled])
    assert dataset.digest([plain]) != dataset.digest([recording(run, noise=1e-3)])
