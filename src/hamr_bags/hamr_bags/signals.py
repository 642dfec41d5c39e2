"""Kinds of drive signal: each a frozen dataclass of its parameters with `deviation()`, volts about neutral, (n, 8), before the clip.

Bags keep the parameters in /run_info; `KINDS` finds the class again by name. A signal lasts whole 4 ms frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS, LEGS, MIRROR, torque_sign
from hamr_description.numbers import number, value
from hamr_description.rates import SERVO_HZ, SUBSTEPS, TARGET_HZ
from hamr_description.units import time_to_si

_RAMP_S = time_to_si(value("excitation.ramp"))
_SECONDS = time_to_si(value("excitation.duration"))
_STD = value("excitation.std")
_BAND_HZ = value("excitation.band_hz")
_GAIT_HZ, _GAIT_V, _RAMP_CYCLES = (value(f"excitation.gait_{name}") for name in ("hz", "amplitude", "ramp_cycles"))
_STEP_HOLD_S = 0.02


class Signal(Protocol):
    """What every kind offers."""

    kind: ClassVar[str]
    seconds: float

    def deviation(self) -> np.ndarray: ...  # (n, 8) V about neutral, n a multiple of 80


def samples(seconds: float) -> int:
    """Servo samples in the whole frames nearest to a duration; ConfigError if that is none."""
    frames = round(seconds * TARGET_HZ) if np.isfinite(seconds) else 0
    if frames < 1:
        raise ConfigError(f"seconds is {seconds}; an excitation needs at least one period of {1 / TARGET_HZ} s.")
    return frames * SUBSTEPS


def _check(path: str, name: str, given: float) -> None:
    low, high = number(path).bounds
    if not low <= given <= high:
        raise ConfigError(f"{name} is {given}; choose {low} to {high} {number(path).unit}.")


def _times(seconds: float) -> np.ndarray:
    return np.arange(samples(seconds)) / SERVO_HZ


def _ramp(t: np.ndarray, rise: float) -> np.ndarray:
    return np.minimum(t / rise, 1.0)[:, None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Band-limited Gaussian voltages, eight independent channels; the passive white-noise run (SEED, REPO).

    The spectrum is made, not filtered: every harmonic k / seconds in (0, band_hz] gets an independent Gaussian amplitude
    in both phases, all others are zero, and one inverse FFT per channel gives the samples. Each channel is scaled so that
    its standard deviation over the run is exactly `std`, before the linear ramp-in of 0.5 s and before the clip to
    0..225 V (which at the default 1.75 sigma cuts 8 % of the samples and puts 0.6 % of the power above the band).
    The mean is neutral exactly. Equal parameters give equal bits on one machine with one numpy.
    """

    kind: ClassVar[str] = "noise"
    seconds: float = _SECONDS
    seed: int = 0
    band_hz: float = _BAND_HZ
    std: float = _STD

    def __post_init__(self) -> None:
        _check("excitation.band_hz", "band_hz", self.band_hz)
        _check("excitation.std", "std", self.std)

    def deviation(self) -> np.ndarray:
        t = _times(self.seconds)
        harmonics = int(self.band_hz * t.size / SERVO_HZ)
        if harmonics < 1:
            raise ConfigError(f"{self.seconds} s hold no full cycle of {self.band_hz} Hz; run longer or widen the band.")
        amplitude = np.random.default_rng(self.seed).standard_normal((len(JOINTS), harmonics, 2))
        spectrum = np.zeros((len(JOINTS), t.size // 2 + 1), complex)
        spectrum[:, 1 : harmonics + 1] = amplitude[..., 0] + 1j * amplitude[..., 1]
        noise = np.fft.irfft(spectrum, t.size).T
        return noise * (self.std / noise.std(axis=0)) * _ramp(t, _RAMP_S)


#: Phase of each leg's cycle, as a share of a cycle.
GAITS = {"trot": {"fl": 0.0, "rl": 0.5, "fr": 0.5, "rr": 0.0}, "pronk": dict.fromkeys(LEGS, 0.0)}


def gait_phases(gait: str) -> np.ndarray:
    """(8,) rad: phase of each drive voltage, V = neutral + A sin(2 pi f t + phase).

    A leg's lift leads its foot up as the sine, its swing takes the foot forward as the cosine of the leg's phase; the
    signs turn that into volts. For the trot this gives the source's phases: all lifts 0, front swings 3 pi / 2, rear
    swings pi / 2.
    """
    phases = []
    for joint in JOINTS:
        leg, axis = joint.split("_")
        left = MIRROR[leg][1]  # + turns about x raise a left foot, + turns about z take it back; right legs the reverse
        sign = torque_sign(joint) * (left if axis == "lift" else -left)
        phases.append(GAITS[gait][leg] + (0.25 if axis == "swing" else 0.0) + (0.0 if sign > 0 else 0.5))
    return 2 * np.pi * np.mod(phases, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trot:
    """Sinusoids of a trot, ramped in over two cycles: `amplitude` V at `frequency_hz` (phases: `gait_phases`)."""

    kind: ClassVar[str] = "trot"
    seconds: float = 1.0
    frequency_hz: float = _GAIT_HZ
    amplitude: float = _GAIT_V

    def deviation(self) -> np.ndarray:
        t = _times(self.seconds)
        wave = np.sin(2 * np.pi * self.frequency_hz * t[:, None] + gait_phases(self.kind))
        return self.amplitude * wave * _ramp(t, _RAMP_CYCLES / self.frequency_hz)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pronk(Trot):
    """All four legs in phase, otherwise as Trot."""

    kind: ClassVar[str] = "pronk"


@dataclass(frozen=True, slots=True, kw_only=True)
class Triangle:
    """Triangle waves of `amplitude` V, channel j delayed by j / 8 of a cycle, ramped in over two cycles."""

    kind: ClassVar[str] = "triangle"
    seconds: float = 1.0
    frequency_hz: float = 10.0
    amplitude: float = _GAIT_V

    def deviation(self) -> np.ndarray:
        t = _times(self.seconds)
        cycle = np.mod(self.frequency_hz * t[:, None] - np.arange(len(JOINTS)) / len(JOINTS) + 0.25, 1.0)
        return self.amplitude * (1 - 4 * np.abs(cycle - 0.5)) * _ramp(t, _RAMP_CYCLES / self.frequency_hz)


@dataclass(frozen=True, slots=True, kw_only=True)
class Steps:
    """Random levels, uniform within +-`amplitude` V, each held for 20 ms, independent channels."""

    kind: ClassVar[str] = "steps"
    seconds: float = 1.0
    seed: int = 0
    amplitude: float = _GAIT_V

    def deviation(self) -> np.ndarray:
        n, hold = samples(self.seconds), round(_STEP_HOLD_S * SERVO_HZ)
        levels = np.random.default_rng(self.seed).uniform(-1, 1, (-(-n // hold), len(JOINTS)))
        return self.amplitude * np.repeat(levels, hold, axis=0)[:n]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mix:
    """Noise (standard deviation `amplitude`), trot, pronk, triangle and steps one after the other, `seconds` / 5 each."""

    kind: ClassVar[str] = "mix"
    seconds: float = 5.0
    seed: int = 0
    amplitude: float = _GAIT_V

    def deviation(self) -> np.ndarray:
        part, size = self.seconds / 5, {"amplitude": self.amplitude}
        parts = [
            Noise(seconds=part, seed=self.seed, std=self.amplitude),
            Trot(seconds=part, **size),
            Pronk(seconds=part, **size),
            Triangle(seconds=part, **size),
            Steps(seconds=part, seed=self.seed, **size),
        ]
        return np.concatenate([signal.deviation() for signal in parts])


KINDS: dict[str, type[Signal]] = {signal.kind: signal for signal in (Noise, Trot, Pronk, Triangle, Steps, Mix)}
