"""The free parameters of a fit, and how they fill the rows of a machine's lanes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hamr_dynamics.effects.law import Form, Parameter, Scales
from hamr_dynamics.effects.library import find
from hamr_dynamics.machine import CHANGES, Machine

#: Prior standard deviation of a parameter change, as a share of what the machine has: weak, it keeps what no data fix from running away.
CHANGE_SD = 0.5
LEFT = 0.05  # share of what the machine has, that a change leaves at least
DRIVE_LEFT = 0.5  # likewise of the drive: one that does next to nothing would explain what sticks
LINEAR = 1e-3  # of the usual force, or of the inertia: what bends less counts as straight
PRELOAD_SD = 3.0  # in scales, and any change of what the machine has not


@dataclass(frozen=True, slots=True)
class Free:
    """One free number: value = scale * x, within low..high in scales, prior N(center, sd) in scales."""

    row: str
    scale: float
    low: float
    high: float
    center: float
    sd: float


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect at a place: what may be named.

    Attributes:
        effect, form: names. joints: indices; both for forms of a pair.
    """

    effect: str
    form: str
    joints: tuple[int, ...]

    @property
    def law(self) -> Form:
        """Its form."""
        return find(self.effect, self.form)

    @property
    def name(self) -> tuple[str, tuple[int, ...]]:
        """Family and place, which is what counts as an answer."""
        return self.effect, self.joints

    @property
    def places(self) -> tuple[int, ...]:
        """Places of the law's rows."""
        return (0,) if self.law.acts == "pair" else self.joints

    def row(self, parameter: Parameter, place: int) -> str:
        """Row of a parameter."""
        return f"{self.effect}.{self.form}.{parameter.name}.{place}"

    def rows(self, *, shape: bool) -> list[tuple[str, Parameter]]:
        """Rows of its sizes or of its shapes."""
        chosen = self.law.shapes if shape else self.law.sizes
        return [(self.row(parameter, place), parameter) for place in self.places for parameter in chosen]


def changes(machine: Machine, scales: Scales, driven: Sequence[bool]) -> list[Free]:
    """What a fair re-tune may change. The gain of what is driven, but not of a single joint whose equations are linear: there no record
    tells a stronger drive from less of everything else."""
    rest, found = machine.at_rest, []
    own = {"stiffness": rest.stiffness, "inertia": rest.mass, "damping": rest.damping}
    told = len(machine.joints) > 1 or not _linear(machine, scales)
    for name, dimension in CHANGES.items():
        for j in range(len(machine.joints)):
            if name == "gain" and not (told and driven[j]):
                continue
            scale = scales.of(dimension)
            has = 1.0 if name == "gain" else float(machine.diagonal(own[name], j)) / scale if name in own else 0.0
            low = ((DRIVE_LEFT if name == "gain" else LEFT) - 1.0) * has if has else -np.inf  # what is left stays positive
            found.append(Free(f"change.{name}.{j}", scale, low, np.inf, 0.0, CHANGE_SD * has or PRELOAD_SD))
    return found


def _linear(machine: Machine, scales: Scales) -> bool:
    """Whether a single joint's equations are, within what is usual: twice as far makes twice the force, either way, of one inertia."""

    def at(share: float) -> tuple[float, float]:
        q, v, u = ((share * x,) for x in (scales.coordinate, scales.coordinate / scales.time, scales.drive))
        terms = machine.terms(q, v, v, u)
        return terms.force[0] - terms.bias[0], terms.mass[0]

    (rest, mass), *others = (at(share) for share in (0.0, 1.0, -1.0, 2.0))
    slopes = [(force - rest) / share for (force, _), share in zip(others, (1.0, -1.0, 2.0), strict=True)]
    return np.ptp(slopes) < LINEAR * scales.force and np.ptp([mass, *(m for _, m in others)]) < LINEAR * mass


def effect_parameters(candidates: Iterable[Candidate], scales: Scales) -> list[Free]:
    """Sizes and shapes of effects. Sizes have a wide prior about zero, shapes one about their typical value."""
    found = []
    for candidate in candidates:
        for shape in (False, True):
            for row, p in candidate.rows(shape=shape):
                center, sd = (p.typical, max(2.0 * p.typical, 0.3 * min(p.high - p.low, 10.0))) if shape else (0.0, 30.0 * p.typical)
                found.append(Free(row, scales.of(p.dimension), p.low, p.high, center, sd))
    return found


def lanes(names: Sequence[str], neutral: np.ndarray, free: Sequence[Free], x: np.ndarray) -> np.ndarray:
    """(K, rows) lane parameters of (K, P) free numbers, with these names and, where nothing is free, neutral (rows,)."""
    full = np.tile(neutral, (len(x), 1))
    index = {name: i for i, name in enumerate(names)}
    for k, f in enumerate(free):
        full[:, index[f.row]] = f.scale * x[:, k]
    return full
