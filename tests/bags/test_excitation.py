"""Drive signals: spectrum, size, clipping, ramp, independence, determinism, gaits."""

from __future__ import annotations

import json
from math import erfc, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hamr_bags.excitation import excitation
from hamr_bags.frames import servo_frame
from hamr_bags.signals import GAITS, KINDS, Noise, gait_phases
from hamr_bags.writer import BagWriter
from hamr_description.errors import BagError, ConfigError
from hamr_description.names import JOINTS, Topic, torque_sign
from hamr_description.rates import SUBSTEPS, TARGET_NS

NEUTRAL = 112.5


def without_ramp(signal: Noise) -> np.ndarray:
    """The stationary noise: the linear ramp of 0.5 s divided out; the first sample (ramp 0) follows from the zero mean."""
    noise = signal.deviation()
    ramp = np.minimum(np.arange(len(noise)) / 20_000 / 0.5, 1.0)[:, None]
    noise[1:] /= ramp[1:]
    noise[0] = -noise[1:].sum(axis=0)
    return noise


@pytest.mark.parametrize(("seconds", "band_hz"), [(12.0, 40.0), (0.5, 20.0), (3.0, 70.0), (0.1, 40.0)])
def test_spectrum_is_exactly_the_band(seconds, band_hz):
    """Also proves the ramp: any other would smear the spectrum."""
    noise = without_ramp(Noise(seconds=seconds, band_hz=band_hz, seed=3))
    power = np.abs(np.fft.rfft(noise, axis=0)) ** 2
    hertz = np.fft.rfftfreq(len(noise), 1 / 20_000)
    inside = (hertz > 0) & (hertz < band_hz + 1e-6)
    assert power[~inside].sum() < 1e-18 * power.sum()
    assert power[inside].min() > 0


@given(st.integers(0, 2**32 - 1), st.floats(5, 100), st.floats(5, 200))
@settings(max_examples=10, deadline=None)
def test_standard_deviation_is_exact_before_the_clip(seed, std, band_hz):
    noise = without_ramp(Noise(seconds=0.6, seed=seed, std=std, band_hz=band_hz))
    assert noise.std(axis=0) == pytest.approx(std, rel=1e-9)


def test_noise_is_gaussian_flat_and_independent():
    noise = without_ramp(Noise(seed=5)) / Noise().std
    assert np.mean(noise**4) == pytest.approx(3.0, abs=0.15)
    power = (np.abs(np.fft.rfft(noise, axis=0)) ** 2).sum(axis=1)
    assert power[1:241].sum() / power[241:481].sum() == pytest.approx(1.0, abs=0.1)  # 2 x 1920 squared Gaussians: sigma 0.03
    correlation = np.corrcoef(noise.T) - np.eye(8)
    assert np.abs(correlation).max() < 0.15  # 960 degrees of freedom: sigma 0.03


def test_voltages_are_clipped_and_start_at_neutral():
    voltages = excitation().voltages
    assert voltages.shape == (240_000, 8)
    assert np.array_equal(voltages[0], np.full(8, NEUTRAL))
    assert voltages.min() == 0.0
    assert voltages.max() == 225.0
    ramped_in = voltages[10_000:]
    assert np.mean((ramped_in == 0) | (ramped_in == 225)) == pytest.approx(erfc(NEUTRAL / Noise().std / sqrt(2)), abs=0.015)
    assert np.abs(voltages[:1000] - NEUTRAL).max() < 0.1 * 4 * Noise().std  # ramp is below 0.1 in the first 50 ms


@pytest.mark.parametrize("kind", KINDS)
def test_equal_parameters_give_equal_bits_also_through_json(kind):
    first = excitation(kind)
    again = excitation(**json.loads(json.dumps(first.parameters)))
    assert first.voltages.tobytes() == again.voltages.tobytes()
    assert again.parameters == first.parameters
    if "seed" in first.parameters:
        assert not np.array_equal(first.voltages, excitation(**first.parameters | {"seed": 1}).voltages)


@given(st.sampled_from(sorted(KINDS)), st.floats(0.3, 1.0))
@settings(max_examples=12, deadline=None)
def test_frames_are_the_whole_signal_in_blocks(kind, seconds):
    whole = excitation(kind, seconds=seconds)
    frames = [whole.frame(k) for k in range(whole.frames)]
    assert np.array_equal(np.concatenate(frames), whole.voltages)
    assert all(frame.shape == (80, 8) for frame in frames)
    for outside in (-1, whole.frames):
        assert np.array_equal(whole.frame(outside), np.full((80, 8), NEUTRAL))
    with pytest.raises(ValueError, match="read-only"):
        frames[0][:] = 0


@given(st.sampled_from(sorted(KINDS)), st.floats(1, 112.5))
@settings(max_examples=12, deadline=None)
def test_voltages_stay_within_their_bounds(kind, amplitude):
    size = {"std": amplitude} if kind == "noise" else {"amplitude": amplitude}
    voltages = excitation(kind, seconds=0.5, **size).voltages
    assert voltages.min() >= 0.0
    assert voltages.max() <= 225.0
    if kind not in ("noise", "mix"):
        assert np.abs(voltages - NEUTRAL).max() <= amplitude * (1 + 1e-12)


def test_trot_is_the_published_one():
    """Speed-check script of the source: 60 Hz, 50 V, ramp of 2 cycles, lifts in phase, front swings 3 pi / 2, rear pi / 2."""
    phases = {"lift": 0.0, "swing": {"f": 3 * np.pi / 2, "r": np.pi / 2}}
    t = np.arange(20_000) / 20_000
    ramp = np.minimum(t * 60 / 2, 1)
    voltages = excitation("trot").voltages
    for j, joint in enumerate(JOINTS):
        phase = 0.0 if joint.endswith("lift") else phases["swing"][joint[0]]
        assert voltages[:, j] == pytest.approx(NEUTRAL + ramp * 50 * np.sin(2 * np.pi * 60 * t + phase), abs=1e-9)


@pytest.mark.parametrize("gait", GAITS)
def test_feet_follow_the_phases_of_the_gait(gait):
    """Quasi-static: foot height and reach per volt, by the axes: x turns raise left feet, z turns take them back."""
    phases = gait_phases(gait)
    up, forward = {}, {}
    for j, joint in enumerate(JOINTS):
        leg, axis = joint.split("_")
        side = 1 if leg[1] == "l" else -1
        wave = torque_sign(joint) * np.exp(1j * phases[j])
        (up if axis == "lift" else forward)[leg] = side * wave if axis == "lift" else -side * wave
    for leg, share in GAITS[gait].items():
        assert up[leg] == pytest.approx(np.exp(2j * np.pi * share))
        assert forward[leg] == pytest.approx(1j * np.exp(2j * np.pi * share))


def test_triangle_has_one_slope_and_steps_hold_20_ms():
    triangle = excitation("triangle", seconds=1.0, frequency_hz=10.0, amplitude=50.0).voltages[5000:]
    slopes = np.abs(np.diff(triangle, axis=0))
    expected = 4 * 50 * 10 / 20_000
    assert np.mean(np.isclose(slopes, expected)) > 0.99
    assert slopes.max() < expected * (1 + 1e-9)
    steps = excitation("steps", seconds=1.0).voltages
    assert np.array_equal(steps[:, 0], np.repeat(steps[::400, 0], 400))
    assert len(np.unique(steps)) == 50 * 8


def test_mix_is_the_other_kinds_one_after_the_other():
    mix = excitation("mix", seconds=2.0, seed=4, amplitude=30.0).voltages
    own = {"noise": {"std": 30.0, "seed": 4}, "trot": {}, "pronk": {}, "triangle": {}, "steps": {"seed": 4}}
    parts = [excitation(kind, seconds=0.4, **({} if kind == "noise" else {"amplitude": 30.0}) | more) for kind, more in own.items()]
    assert np.array_equal(mix, np.concatenate([part.voltages for part in parts]))


@pytest.mark.parametrize(
    ("kind", "parameters", "said"),
    [
        ("pink", {}, "choose one of noise, trot"),
        ("trot", {"band_hz": 3.0}, "no parameter 'band_hz'"),
        ("noise", {"band_hz": 0.0}, "band_hz is 0.0; choose 1 to 500 Hz"),
        ("noise", {"std": float("nan")}, "std is nan"),
        ("noise", {"seconds": 0.0}, "at least one period"),
        ("trot", {"seconds": float("inf")}, "at least one period"),
        ("noise", {"seconds": 0.02}, "run longer or widen the band"),
    ],
)
def test_bad_parameters_are_named(kind, parameters, said):
    with pytest.raises(ConfigError, match=said):
        excitation(kind, **parameters)


def test_a_recorded_run_is_played_again(tmp_path):
    volts = excitation("steps", seconds=0.1, seed=4).voltages
    frame = servo_frame(Topic.SERVO_VOLTAGES, SUBSTEPS)
    with BagWriter(tmp_path / "bag") as bag:
        for k in (*range(10, 25), *range(10)):  # messages may lie in any order
            frame.stamp(k * TARGET_NS)
            frame.numbers["effort"][:] = volts[k * SUBSTEPS : (k + 1) * SUBSTEPS]
            bag.write(Topic.SERVO_VOLTAGES, bytes(frame), k * TARGET_NS)
    again = excitation("bag", path=str(tmp_path / "bag"))
    assert np.array_equal(again.voltages, volts)
    assert np.array_equal(excitation(**json.loads(json.dumps(again.parameters))).voltages, volts)
    assert np.array_equal(excitation("bag", path=str(tmp_path / "bag"), seconds=0.02).voltages, volts[:400])
    with pytest.raises(BagError, match="0.1 s of voltages"):
        excitation("bag", path=str(tmp_path / "bag"), seconds=0.2)


def test_slower_voltages_are_not_played(tmp_path):
    frame = servo_frame(Topic.SERVO_VOLTAGES, 16)
    with BagWriter(tmp_path / "bag") as bag:
        bag.write(Topic.SERVO_VOLTAGES, bytes(frame), 0)
    with pytest.raises(BagError, match="80 samples"):
        excitation("bag", path=str(tmp_path / "bag"))
