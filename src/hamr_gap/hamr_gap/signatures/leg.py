"""The suspended front-left leg of HAMR-simple, its swing joint driven, with an effect and without.

The lift joint is clamped, so that the leg has one resonance, except where it is what is looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from hamr_description.rates import SERVO_HZ
from hamr_dynamics import machine_kernel
from hamr_dynamics.bank_stages import USUAL
from hamr_dynamics.effects.effects_file import PlacedEffect
from hamr_dynamics.machine import Machine
from hamr_dynamics.set_effects import inside

from ..legs import machine_of

LEG = "fl"
SWING, LIFT, TIP = 0, 1, 2  # channels of the leg
STEP = 1e3 / SERVO_HZ  # ms
SETTLE, WATCH = 450.0, 100.0  # ms until a sine has settled, and for which it is watched, at least
CLAMP = (1000.0, 100.0)  # stiffness and damping added to a clamped joint, inside units


@cache
def leg() -> Machine:
    """The leg, which all experiments share."""
    return machine_of("simple", LEG)


@dataclass(frozen=True)
class Bench:
    """A leg with an effect and without: the first axis of all that it gives.

    Args:
        placed: the effect. clamped: whether the lift joint is held.
    """

    placed: PlacedEffect
    clamped: bool = True

    @property
    def rows(self) -> np.ndarray:
        """(2, rows) lane parameters, without and with."""
        machine = leg()
        place = 0 if self.placed.law.acts == "pair" else machine.joints.index(self.placed.joints[0])
        rows = np.tile(machine.neutral(USUAL), (2, 1))
        index = {name: i for i, name in enumerate(machine.parameter_rows)}
        for name, value in inside(self.placed).items():
            rows[1, index[f"{self.placed.effect}.{self.placed.form}.{name}.{place}"]] = value
        if self.clamped:
            rows[:, [index[f"change.{name}.{LIFT}"] for name in ("stiffness", "damping")]] = CLAMP
        return rows

    def run(self, drives: Sequence[np.ndarray], substeps: int) -> np.ndarray:
        """Readings (2, drives, n, channels) from rest under drives of the swing joint, each (n * substeps,) V, of one length."""
        count, length = len(drives), len(drives[0])
        both = np.zeros((count * length, 2))
        both[:, 0] = np.concatenate(drives)
        y = machine_kernel.simulate(
            leg(), both, np.repeat(self.rows, count, axis=0), step=STEP, substeps=substeps, samples=length // substeps,
            first=np.tile(np.arange(count) * length, 2),
        )  # fmt: skip
        return y.reshape(2, count, *y.shape[1:])

    def response(self, hertz: np.ndarray, volts: float, bias: float = 0.0, channel: int = SWING) -> np.ndarray:
        """(2, frequencies) complex, rad/V: first harmonic of a reading under settled sines about a bias."""
        length = SETTLE + np.ceil(max(WATCH, 1e3 / hertz[0]))
        t = np.arange(round(length / STEP)) * STEP
        soft = eased(t / 200.0)
        y = self.run([soft * (bias + volts * np.sin(2e-3 * np.pi * f * t)) for f in hertz], 5)[..., channel]
        return np.stack([_harmonic(y[:, i], t[::5], f) for i, f in enumerate(hertz)], 1) / volts


def eased(x: np.ndarray) -> np.ndarray:
    """0 to 1 along half a cosine, for x from 0 to 1."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(x, 0.0, 1.0))


def _harmonic(y: np.ndarray, t: np.ndarray, hertz: float) -> np.ndarray:
    """(2,) complex amplitude over the last whole periods; a held drive acts half a step late."""
    w = 2e-3 * np.pi * hertz
    last = t > t[-1] - np.ceil(1e-3 * WATCH * hertz) / (1e-3 * hertz)
    waves = np.stack([np.sin(w * t[last]), np.cos(w * t[last]), np.ones(last.sum())], 1)
    (a, b, _) = np.linalg.lstsq(waves, y[:, last].T)[0]
    return (a + 1j * b) * np.exp(0.5j * w * STEP)
