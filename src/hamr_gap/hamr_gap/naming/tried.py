"""What a search has tried, and what of it may be the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..data.readings import noise_of
from ..fitting.weighed import Weighed
from .blocks import THROUGHOUT, better
from .hypothesis import Hypothesis, residual
from .screen import Screen
from .simpler import HARMLESS

EARNED = 1.01  # by how much each further parameter of a form must lower what is left
AS_WELL, RIVAL_FORMS = 1.03, 3  # times what one form leaves, that others may leave to do about as well, and how many with it
RIVAL = 4.0  # times what more effects leave, that fewer may leave and be as probable
ENOUGH = 0.001  # of the gap: nothing smaller is looked for
SMALL = 0.02  # of the gap: as much as forms of one name differ by, so that what takes less away may be anything
FAINT = 1.0  # squared units of noise of a reading: less than half a floor is not looked into further
FLOOR_ERROR = 0.03  # of the estimate of what noise leaves


@dataclass
class Search:
    """What was tried.

    Attributes:
        weighed: the model that was tried, perhaps better timed than the one the search began with.
        base: the re-tuned model without effects, perhaps better than that one too. seen: the linear picture about it.
        count: judged readings. tried: all hypotheses with effects. floor: mean square that noise alone leaves.
        rough: whether short pieces led fits of single effects to less.
    """

    weighed: Weighed
    base: Hypothesis
    seen: Screen
    count: int
    tried: list[Hypothesis] = field(default_factory=list)
    floor: float = 1.0
    rough: bool = False

    @property
    def best(self) -> Hypothesis:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    @property
    def fewest(self) -> Hypothesis:
        """The one with fewest effects that may yet be the answer; of as many, the one that leaves least."""
        alike = (h for h in self.tried if h.left < RIVAL * self.best.left)
        return min(alike, key=lambda h: (len(h.effects), h.left), default=self.base)

    @property
    def enough(self) -> float:
        """Mean square above the noise that is not looked into further."""
        return max(FAINT, ENOUGH * (self.base.left - self.floor))

    def best_of(self, size: int) -> Hypothesis:
        """The same of those with so many effects."""
        return min((h for h in self.tried if len(h.effects) == size), key=lambda h: h.left)

    def by_names(self) -> dict[frozenset, Hypothesis]:
        """The best hypothesis for every set of names; of forms the one with fewest parameters that does as well but for a few blocks."""
        forms: dict[frozenset, list[Hypothesis]] = {}
        for h in sorted(self.tried, key=lambda h: h.left * EARNED**h.parameters):
            forms.setdefault(h.names, []).append(h)
        return {names: _simplest(found) for names, found in forms.items()}

    def forms_of(self, h: Hypothesis) -> list[Hypothesis]:
        """A hypothesis, and the other forms of its name that do about as well; the best first of these."""
        best = {h.effects: h}
        for other in sorted(self.tried, key=lambda o: o.left):
            if other.names == h.names and other.left < AS_WELL * h.left:
                best.setdefault(other.effects, other)
        return list(best.values())[:RIVAL_FORMS]


def _simplest(forms: Sequence[Hypothesis]) -> Hypothesis:
    """Of forms of one name, the best first, the one with fewest parameters that is no worse throughout: chance may be all there is."""
    best = forms[0]
    alike = [h for h in forms if h.left < HARMLESS * best.left and better(h.blocks, best.blocks) < THROUGHOUT]
    return min(alike, key=lambda h: h.parameters, default=best)


def noise_floor(weighed: Weighed, best: Hypothesis) -> float:
    """Mean square that noise and the simulation's own error leave, from differences of the best hypothesis' residual."""
    noise = float(np.mean(noise_of(residual(weighed, best.fit)) ** 2))
    return min(noise + weighed.model.mean * weighed.numerical**2, best.left)
