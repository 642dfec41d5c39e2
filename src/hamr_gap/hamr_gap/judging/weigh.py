"""From what each hypothesis leaves to a probability for each set of names, and to a verdict.

What a name leaves of the gap on readings that were not fitted is compared on a logarithmic scale: laws of one name differ, so a
few per cent of the gap decide nothing, while a name that leaves half of it is wrong where another leaves a tenth. The constants
were chosen on development cases of `hamr gap bench` and are reported on others.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hamr_dynamics.effects.library import library

from ..naming.blocks import THROUGHOUT, better
from ..naming.hypothesis import Hypothesis
from ..naming.tried import FLOOR_ERROR, SMALL, Search

SHARPNESS = 3.0  # log odds per factor e in what is left; twice that beyond `UNKNOWN`, where no right name should be
FORM_ERROR = 0.0001  # of the gap: nothing is told apart below this
ANOTHER_EFFECT = 4.5  # log odds against a second effect: it must leave less than a quarter
ONE_MORE = 3.0  # log odds against each beyond the second
ANOTHER_PLACE = 3.0  # log odds against each further joint of one effect
FREER = 0.3  # log odds against a factor e in the number of sizes and shapes: they are judged where they were not fitted
CONTAINS = 3.0  # log odds against a name that has another, simpler one as its special case
UNKNOWN = 0.1  # of the gap: where names leave more, none of the library is right; known laws left up to 0.06, most others 0.14 and more
IMPOSSIBLE = 0.2  # of the gap: what leaves more is no answer where names that are about as probable leave less than `UNKNOWN`
COVERAGE = 0.9  # of a set
DECIDES = 8.0  # half squared distance in units of noise below which data tell nothing apart (d' of 4)


@dataclass(frozen=True)
class Weight:
    """A hypothesis (None: a law outside the library), its share of the gap left, and its probability."""

    hypothesis: Hypothesis | None
    left: float
    probability: float


def weigh(state: Search, nothing: float = 0.0) -> list[Weight]:
    """Probabilities of all sets of names tried and of "unknown", most probable first.

    Args:
        nothing: mean square, in units of the noise, that would be no gap if it were all: nothing unknown is in it.
    """
    found: list[tuple[Hypothesis | None, float, float]] = []
    best = state.by_names()
    nearest = min(best.values(), key=lambda h: h.left, default=None)
    floor, gap, least = scale_of(state, best.values())
    for names, h in best.items():
        if any(better(best[few].blocks, h.blocks) < THROUGHOUT for few in best if few < names or _special(few, names)):
            continue
        left = max(surely_left(h, nearest, state.floor) - floor, 0.0) / gap
        if left < 1.0:
            places = sum(len(c.places) - 1 for c in h.effects if library()[c.effect].smooth)  # the others are seen at each joint by itself
            wide = sum(bool(library()[c.effect].contains) for c in h.effects)
            price = ANOTHER_EFFECT * (len(h.effects) > 1) + ONE_MORE * max(len(h.effects) - 2, 0)
            price += ANOTHER_PLACE * places + FREER * np.log(h.parameters) + CONTAINS * wide
            taken = min(((best[few].left - h.left) / gap for few in best if few < names), default=1.0)
            price += SHARPNESS * max(0.0, np.log(SMALL / max(taken, FORM_ERROR)))
            found.append((h, left, log_odds(left, least) - price))
    # a law outside the library competes with the first names by what they leave, whatever their price
    first = max((s for *_, s in found), default=0.0)
    left = max(min((left for _, left, s in found if s >= first - CONTAINS), default=UNKNOWN) - nothing / gap, 0.0)
    if left < UNKNOWN:
        found = [(h, share, s if share < IMPOSSIBLE else -np.inf) for h, share, s in found]
        first = max((s for *_, s in found), default=0.0)
    found.append((None, UNKNOWN, first + log_odds(UNKNOWN, least) - log_odds(left, least)))
    score = np.array([s for *_, s in found])
    p = np.exp(score - score.max())
    p /= p.sum()
    return sorted((Weight(h, left, float(x)) for (h, left, _), x in zip(found, p, strict=True)), key=lambda w: -w.probability)


def log_odds(left: float, least: float) -> float:
    """For a name that leaves a share of the gap, whatever it costs; less than `least` tells nothing."""
    beyond = max(0.0, np.log((left + least) / (UNKNOWN + least)))
    return -SHARPNESS * (np.log(left + least) + beyond)


def scale_of(state: Search, best: Iterable[Hypothesis]) -> tuple[float, float, float]:
    """Mean square that noise is taken to leave, the gap above it, and the share of that below which nothing is told apart.

    Args:
        best: the best of all names tried.
    """
    floor = floor_of(state.floor, best)
    gap = max(state.base.left - floor, 1e-12)
    return floor, gap, least_told(gap, state.count)


def floor_of(noise: float, best: Iterable[Hypothesis]) -> float:
    """Mean square that noise is taken to leave, of its estimate: what the best leaves, where the estimate's error allows it.

    On readings that no fit has seen nothing leaves less than the noise, and what two names differ by is known far better than the noise.
    """
    return min([(1.0 + FLOOR_ERROR) * noise, *(h.left for h in best)])


def surely_left(h: Hypothesis, best: Hypothesis, noise: float) -> float:
    """What a hypothesis leaves; less by the error of the noise, but no less than the best, where it does not leave more throughout."""
    return h.left if better(h.blocks, best.blocks) >= THROUGHOUT else max(best.left, h.left - FLOOR_ERROR * noise)


def least_told(gap: float, count: float) -> float:
    """Share of a gap below which nothing is told apart.

    Args:
        gap: mean square above the floor, in units of the noise. count: judged readings.
    """
    return FORM_ERROR + 2.0 * DECIDES / count / gap


def _special(few: frozenset, names: frozenset) -> bool:
    """Whether names differ from others in one, of which they have special cases, or the same, at the same joints or some of them."""
    own, others = few - names, names - few
    return len(others) == 1 and bool(own) and all(within(name, *others) for name in own)


def within(simple: tuple, wide: tuple) -> bool:
    """Whether a name (effect, joints) is a special case of another, or the same, at the same joints or some of them."""
    (effect, joints), (its, all_joints) = simple, wide
    return effect in (its, *library()[its].contains) and set(joints) <= set(all_joints)


def akin(effect: str, other: str) -> bool:
    """Whether two effects are the same, or one has the other as a special case."""
    return effect in (other, *library()[other].contains) or other in library()[effect].contains


def credible(weights: Sequence[Weight], coverage: float = COVERAGE) -> list[Weight]:
    """The smallest set of the most probable that holds some coverage."""
    total, chosen = 0.0, []
    for w in weights:
        chosen.append(w)
        total += w.probability
        if total >= coverage:
            break
    return chosen
