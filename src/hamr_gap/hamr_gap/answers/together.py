"""Machines that are built alike, as a robot's legs are: what is missing at each is more likely the same than not.

Each combination of the machines' answers has the product of their probabilities, times `ALIKE` where all say the same. Among the
answers that are the same everywhere, each machine speaks for itself by less: laws of one name are wrong at every leg in the same way, so
that four legs are no four witnesses. What they say on average decides there (the geometric mean of their probabilities).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from ..judging.weigh import COVERAGE
from .found import Found

ALIKE = 100.0  # odds for what is the same at all machines, against any one combination of different answers
MOST = 12  # combinations in a set


@dataclass(frozen=True)
class Combination:
    """An answer of each machine that has any, as numbers in its `Found.answers`, and the probability of all together."""

    numbers: dict[str, int]
    probability: float


def together(founds: Mapping[str, Found]) -> tuple[dict[str, Found], list[Combination]]:
    """Every machine led by its part of the most probable combination, and the smallest set of combinations that holds `COVERAGE`."""
    found = _most_probable(founds)
    led = {name: f.led_by(found[0].numbers[name]) if found and name in found[0].numbers else f for name, f in founds.items()}
    return led, found


def _most_probable(founds: Mapping[str, Found]) -> list[Combination]:
    """Combinations until they hold the coverage, most probable first."""
    speaking = {name: f.answers for name, f in founds.items() if f.verdict["set"]}
    sets = [range(len(founds[name].verdict["set"])) for name in speaking]
    alike = _alike(list(speaking.values())) if 1 < len(speaking) == len(founds) else {}
    own = {numbers: _product(speaking, numbers) for numbers in product(*sets) if numbers not in alike} if speaking else {}
    both = {numbers: _product(speaking, numbers) for numbers in alike}
    total = 1.0 + (ALIKE - 1.0) * sum(both.values())
    probability = {numbers: p / total for numbers, p in own.items()}
    probability |= {numbers: ALIKE * sum(both.values()) * share / total for numbers, share in alike.items()}
    chosen: list[Combination] = []
    for numbers in sorted(probability, key=lambda n: -probability[n])[:MOST]:
        chosen.append(Combination(dict(zip(speaking, numbers, strict=True)), probability[numbers]))
        if sum(c.probability for c in chosen) >= COVERAGE:
            break
    return chosen


def _alike(answers: Sequence[Sequence[Mapping]]) -> dict[tuple[int, ...], float]:
    """The same answer of every machine -> its share of all such."""
    each = [{_names(a): k for k, a in enumerate(some) if not a["unknown"]} for some in answers]
    common = [names for names in each[0] if all(names in other for other in each)]
    numbers = [tuple(one[names] for one in each) for names in common]
    mean = [prod(some[k]["probability"] for some, k in zip(answers, n, strict=True)) ** (1.0 / len(answers)) for n in numbers]
    return {n: x / sum(mean) for n, x in zip(numbers, mean, strict=True)}


def _names(answer: Mapping) -> frozenset:
    """Effects and their places, as they are called at any leg."""
    return frozenset((e["effect"], tuple(joint.rpartition("_")[2] for joint in e["joints"])) for e in answer["effects"])


def _product(speaking: Mapping[str, Sequence[Mapping]], numbers: Sequence[int]) -> float:
    return prod(answers[k]["probability"] for answers, k in zip(speaking.values(), numbers, strict=True))
