"""Conditions in which names cannot be told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .case import Case

ANGLES = ("angles",)


def twin(case: Case, random: np.random.Generator) -> tuple[Case, str, tuple[int, ...]]:
    """The case under conditions that hide the difference, the family hidden, and its place."""
    joint = (int(random.integers(2)),)
    build, names = PAIRS[case.seed % len(PAIRS)]
    family = names[case.seed // len(PAIRS) % len(names)]
    return build(case, random), family, joint


def _open_loop(case: Case, random: np.random.Generator) -> Case:
    """Angles alone, voltages not answering to them: what is late in the drive is late in the sensor."""
    return replace(case, channels=ANGLES)


def _slow(case: Case, random: np.random.Generator) -> Case:
    """A band so low that a lag is a delay."""
    seed = int(random.integers(2**31))
    slow = {"kind": "noise", "seconds": case.seconds, "seed": seed, "band_hz": float(random.uniform(2.0, 5.0)), "std": 50.0}
    return replace(case, channels=ANGLES, excitation=slow)


def _one_tone(case: Case, random: np.random.Generator) -> Case:
    """One frequency at one amplitude, far below resonance: the third harmonic alone tells."""
    hertz, volts = float(random.uniform(3.0, 12.0)), float(random.uniform(60.0, 110.0))
    return replace(case, excitation={"kind": "trot", "seconds": case.seconds, "frequency_hz": hertz, "amplitude": volts})


def _gentle(case: Case, random: np.random.Generator) -> Case:
    """Voltages so small that every curve is its first bend, and coarse sensors."""
    seed = int(random.integers(2**31))
    weak = {"kind": "noise", "seconds": case.seconds, "seed": seed, "band_hz": 20.0, "std": float(random.uniform(12.0, 25.0))}
    return replace(case, excitation=weak, noise=float(np.exp(random.uniform(np.log(1e-3), np.log(4e-3)))))


PAIRS = (
    (_open_loop, ("drive_delay", "sensor_latency")),
    (_open_loop, ("drive_lag", "sensor_lag")),
    (_slow, ("drive_lag", "drive_delay", "sensor_lag", "sensor_latency")),
    (_one_tone, ("cubic_stiffness", "drive_saturation", "voltage_dependent_gain")),
    (_one_tone, ("coulomb_friction", "piezo_hysteresis", "quadratic_damping")),
    (_gentle, ("voltage_dependent_gain", "drive_saturation")),
    (_gentle, ("coulomb_friction", "stribeck_friction")),
    (_gentle, ("structural_damping", "viscoelasticity")),
)
