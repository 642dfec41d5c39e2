"""What a search on the ground has tried."""

from __future__ import annotations

from dataclasses import dataclass, field

from .fit import Fit
from .left import Judged, exceeds
from .prepare import Prepared


@dataclass
class Search:
    """What was tried: hypotheses with effects, about the re-tuned robot."""

    prepared: Prepared
    tried: list[Judged] = field(default_factory=list)

    @property
    def base(self) -> Judged:
        """The re-tuned model."""
        return self.prepared.base

    @property
    def best(self) -> Judged:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    @property
    def count(self) -> int:
        """Judged readings."""
        judged = self.prepared.parts["select"]
        return len(judged) * judged.observed.readings

    @property
    def floor(self) -> float:
        """Mean square that noise leaves."""
        return min(self.prepared.floor, self.best.left)

    @property
    def gains(self) -> bool:
        """Whether the best takes off as much as counts as a gap."""
        return exceeds(self.base, self.best, self.prepared.least)

    def judged(self, found: Fit) -> Judged:
        """A fit as a hypothesis, judged on segments that it has not seen."""
        return Judged(found.effects, found, *self.prepared.judge("select", found.model))

    def by_names(self) -> dict[frozenset, Judged]:
        """The best hypothesis for every set of names."""
        found: dict[frozenset, Judged] = {}
        for h in self.tried:
            if h.names not in found or h.left < found[h.names].left:
                found[h.names] = h
        return found
