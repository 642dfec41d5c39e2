"""Drive signals for a proposed experiment: shapes within plus and minus one, at the pace of the machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from hamr_dynamics.machine import Machine

#: Shares of the largest drive that noise has as rms, and its band, in the machine's own pace. Well above its resonance a machine can be
#: driven hard and moves little, and delays and lags show most where all is fast.
NOISES = {"gentle noise": (0.15, 0.0, 2.0), "strong noise": (0.45, 0.0, 2.0), "fast noise": (0.5, 2.0, 4.0)}
SAMPLED = 0.8  # of half the sampling rate, that noise may be as fast as
CREST, ROUNDS = 1.7, 10  # of its rms, that noise is kept below again and again, without leaving its band: its peaks come down to twice it
PARTS, EACH = ("slow triangles", "gentle noise", "strong noise", "chirp"), "a bit of each"
SIGNALS = ("slow triangles", *NOISES, "chirp", "steps that hold", EACH)


def signals(machine: Machine, step: float, count: int, seed: int = 0, names: Sequence[str] = SIGNALS) -> dict[str, np.ndarray]:
    """Name -> (count, joints) signal, of slow triangles, noise at two levels and a fast one, a chirp, steps that hold, and a bit of each.

    Args:
        step: T between samples. seed: of the noise and the steps. names: of the signals that are made.
    """
    rest, n = machine.at_rest, len(machine.joints)
    rates = [np.sqrt(abs(machine.diagonal(rest.stiffness, j)) / machine.diagonal(rest.mass, j)) / (2 * np.pi) for j in range(n)]
    pace = max(max(rates), 20.0 / (count * step))  # cycles per T; of a machine without a spring, some in the run
    make = _parts(n, pace, step, count, seed)
    make[EACH] = lambda: np.concatenate(
        [_parts(n, pace, step, part, seed)[name]() for name, part in zip(PARTS, _quarters(count), strict=True)]
    )
    return {name: make[name]() * np.minimum(np.arange(count) * step * pace / 10.0, 1.0)[:, None] for name in names}


def _quarters(count: int) -> list[int]:
    edges = np.linspace(0, count, len(PARTS) + 1).astype(int)
    return np.diff(edges).tolist()


def _parts(n: int, pace: float, step: float, count: int, seed: int) -> dict[str, Callable[[], np.ndarray]]:
    t = np.arange(count)[:, None] * step * pace  # in periods of the machine
    phase = np.arange(n) / (2.0 * n)
    random = np.random.default_rng(seed)
    white = random.standard_normal((count // 2 + 1, n, 2)) @ (1.0, 1j)
    rates = np.fft.rfftfreq(count, step) / pace

    def noise(level: float, slowest: float, fastest: float) -> np.ndarray:
        slower = min(1.0, SAMPLED * rates[-1] / fastest)
        band = ((slower * slowest <= rates) & (rates <= slower * fastest))[:, None]
        x = np.fft.irfft(white * band, count, axis=0)
        for _ in range(ROUNDS):
            most = CREST * x.std(axis=0)
            x = np.fft.irfft(np.fft.rfft(np.clip(x, -most, most), axis=0) * band, count, axis=0)
        return x * np.minimum(level / x.std(axis=0), 1.0 / np.abs(x).max(axis=0))

    span = t[-1, 0] + 1e-9
    low, high = 0.05, 2.0
    sweep = span * low / np.log(high / low) * ((high / low) ** (t / span) - 1.0)
    hold = 25  # periods that a level lasts
    levels = random.uniform(-1.0, 1.0, (int(span / hold) + 1, n))
    return {
        "slow triangles": lambda: 4.0 * np.abs(np.mod(t / 40.0 + phase + 0.25, 1.0) - 0.5) - 1.0,
        **{name: partial(noise, *kind) for name, kind in NOISES.items()},
        "chirp": lambda: 0.6 * np.sin(2.0 * np.pi * (sweep + phase)),
        "steps that hold": lambda: levels[np.minimum((t[:, 0] / hold).astype(int), len(levels) - 1)],
    }
