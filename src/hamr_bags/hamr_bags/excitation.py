"""Drive voltages of an excitation run: whole, or block by block for the node that drives the bus."""

from __future__ import annotations

from dataclasses import asdict, fields

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.numbers import value
from hamr_description.rates import SUBSTEPS

from .replay import Replay
from .signals import KINDS, Signal


class Excitation:
    """A signal turned into voltages.

    Attributes:
        parameters: JSON-able {"kind": ..., and the signal's own}; `excitation(**parameters)` makes the same again.
        voltages: (n, 8) V in 0..225, float64, read-only, 20 kHz, canonical joint order; n is a multiple of 80.
        frames: number of 4 ms periods, n / 80.
    """

    __slots__ = ("frames", "parameters", "voltages")

    def __init__(self, signal: Signal) -> None:
        self.parameters = {"kind": signal.kind, **asdict(signal)}
        low, high = value("actuator.ground_voltage"), value("actuator.bias_voltage")
        self.voltages = np.clip(value("actuator.neutral_voltage") + signal.deviation(), low, high)
        self.voltages.setflags(write=False)
        self.frames = len(self.voltages) // SUBSTEPS

    def frame(self, k: int) -> np.ndarray:
        """(80, 8) V of period k; neutral before the start and after the end."""
        if 0 <= k < self.frames:
            return self.voltages[k * SUBSTEPS : (k + 1) * SUBSTEPS]
        return np.full((SUBSTEPS, self.voltages.shape[1]), value("actuator.neutral_voltage"))


def excitation(kind: str = "noise", **parameters: float | str) -> Excitation:
    """Excitation by name of its kind; ConfigError lists the kinds or the parameters there are."""
    kinds = KINDS | {Replay.kind: Replay}
    if kind not in kinds:
        raise ConfigError(f"There is no excitation '{kind}'; choose one of {', '.join(kinds)}.")
    known = [field.name for field in fields(kinds[kind])]
    if unknown := sorted(set(parameters) - set(known)):
        raise ConfigError(f"Excitation '{kind}' has no parameter '{unknown[0]}'; it takes {', '.join(known)}.")
    return Excitation(kinds[kind](**parameters))
