"""What would decide between two names: the drive signal under which the second, refitted, explains the first least.

Both fitted rivals are simulated under every signal of `excite`. What a refit of the second to the first would still do is projected
out linearly; what is left over the noise is d'. Laws of one name differ by `weigh.FORM_ERROR` of their signature, which counts as noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .excite import signals
from .hypothesis import Hypothesis
from .linear import jacobian
from .model import Model
from .prepare import Prepared
from .sensors import Sensors
from .weigh import FORM_ERROR

TRIED_S = 4.0  # of each signal
ENOUGH = 5.0  # d' that decides
LONGEST_S = 120.0
SMALLER = 8  # times, at most
SHORTEST_S = 4.0  # a record needs as much to be divided


@dataclass(frozen=True)
class Proposal:
    """An experiment.

    Attributes:
        signal: name; empty if none decides. seconds: for a d' of `ENOUGH`. d_prime: name -> d' in `TRIED_S`.
        drives: (n, joints) U, deviations about neutral, at the record's step.
    """

    signal: str
    seconds: float
    d_prime: dict[str, float]
    drives: np.ndarray

    def as_dict(self, rivals: tuple[str, str]) -> dict:
        """As in `verdict.json`."""
        between = f"between {rivals[0]} and {rivals[1]}"
        sentence = (
            f"{self.signal} for {self.seconds:.0f} s would decide {between}." if self.signal
            else f"no drive signal within the limits decides {between} with these sensors; "
                 "another sensor, a load, a known added mass or closed loop may."
        )  # fmt: skip
        return {"rivals": list(rivals), "signal": self.signal, "seconds": self.seconds, "d_prime": self.d_prime, "sentence": sentence}


def propose(prepared: Prepared, first: Hypothesis, second: Hypothesis, *, seed: int = 0) -> Proposal:
    """The best experiment between two fitted hypotheses, within the largest drives and the widest motion that were measured.

    Args:
        seed: of noise in the signals.
    """
    model = prepared.weighed.model
    machine, record = model.machine, model.record
    step = record.step / record.drives_per_reading
    limit = np.abs(record.drives).max(axis=0)
    found = {}
    for name, shape in signals(machine, step, _samples(prepared, TRIED_S), seed).items():
        found[name] = _d_prime(_driven(model, _within(model, limit * shape, first, second)), prepared, first, second)
    best = max(found, key=found.get)
    seconds = max(SHORTEST_S, TRIED_S * (ENOUGH / max(found[best], 1e-9)) ** 2)
    if seconds > LONGEST_S:
        return Proposal("", 0.0, found, np.empty((0, len(machine.joints))))
    drives = _within(model, limit * signals(machine, step, _samples(prepared, seconds), seed)[best], first, second)
    return Proposal(best, seconds, found, drives)


def _samples(prepared: Prepared, seconds: float) -> int:
    model = prepared.weighed.model
    per = model.record.drives_per_reading
    return int(seconds / model.machine.to_si["T"] / model.record.step) * per


def _driven(model: Model, drives: np.ndarray) -> Model:
    record = model.record
    readings = np.zeros((len(drives) // record.drives_per_reading, len(record.channels)))
    return replace(model, record=replace(record, drives=drives, readings=readings, rest=True, breaks=(), held=False))


def _within(model: Model, drives: np.ndarray, *rivals: Hypothesis) -> np.ndarray:
    """Drives, smaller where a rival would go further than was measured: into end stops, where nothing can be predicted."""
    reach = np.nanmax(np.abs(model.target), axis=0)
    for _ in range(SMALLER):
        driven = _driven(model, drives)
        runs = [driven.runs(h.fit.free, h.fit.x)[0] for h in rivals]
        with np.errstate(invalid="ignore"):
            over = max(float(np.max(np.abs(y) / reach)) if np.isfinite(y).all() else 2.0 for y in runs)
        if over <= 1.0:
            break
        drives = drives / over
    return drives


def _d_prime(model: Model, prepared: Prepared, first: Hypothesis, second: Hypothesis) -> float:
    base = prepared.base.fit
    a, plain = (model.runs(h.free, h.x)[0] for h in (first.fit, base))
    free, x = second.fit.free, second.fit.x
    b = model.runs(free, x)[0]
    sigma = np.sqrt(prepared.weighed.sigma**2 + FORM_ERROR * np.mean((a - plain) ** 2, axis=0))
    weighed = replace(prepared.weighed, model=model, chosen=np.ones_like(b, bool), sigma=sigma, initial=None)
    columns = jacobian(weighed, free, x, b, Sensors.none(b.shape[1]))
    ridge = np.zeros(columns.shape[1])
    ridge[: len(free)] = [1.0 / f.sd for f in free]
    apart = np.r_[weighed.vector(a - b), np.zeros(len(ridge))]
    matrix = np.vstack([columns, np.diag(ridge)])
    if not (np.isfinite(matrix).all() and np.isfinite(apart).all()):
        return 0.0  # a rival that diverges under this signal says nothing
    left = apart - matrix @ np.linalg.lstsq(matrix, apart, rcond=None)[0]
    return float(np.linalg.norm(left))
