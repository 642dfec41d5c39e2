"""Drawing cases: a seed gives one, always the same."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hamr_description.errors import ConfigError

from .case import CHANNELS, JOINTS, Case, Effect
from .conditions import conditions, null
from .laws.law import LAWS, Law
from .sizing import Sizer
from .twins import twin

ATTEMPTS = 40
OUTSIDE = "outside"
#: Share of parameters drawn from a range three times as wide on either side.
BEYOND = 0.1


def families() -> tuple[str, ...]:
    """Names of the structural effects that a case can hide."""
    return tuple(sorted({law.family for law in LAWS.values()} - {OUTSIDE}))


def laws_of(family: str) -> tuple[Law, ...]:
    """The laws of a family, or of OUTSIDE."""
    return tuple(law for law in LAWS.values() if law.family == family)


def draw(group: str, seed: int, *, strength: float = 5.0, seconds: float = 12.0) -> Case:
    """Draw a case.

    Args:
        group: one of GROUPS.
        seed: equal arguments give equal cases; families take turns with it.
        strength: rms of the effect after re-tuning, in floors of the sensor noise; of each effect where there are several.
        seconds: length of the run.

    Returns:
        A case that reaches the strength within 5 %, or what `reached` says for a null. ConfigError if no draw does.
    """
    if group not in GROUPS:
        raise ConfigError(f"There is no group '{group}' of hidden cases; choose one of {', '.join(GROUPS)}.")
    for attempt in range(ATTEMPTS):
        random = np.random.default_rng([list(GROUPS).index(group), seed, attempt])
        empty = Case(f"{group}-{seed}", group, seed, (), {}, seconds, {}, 0.0, "white", CHANNELS, strength)
        if case := GROUPS[group](conditions(empty, random), random):
            return case
    raise ConfigError(f"No case of group '{group}', seed {seed}, has strength {strength} within physical bounds; ask for less.")


def effect(law: Law, random: np.random.Generator, place: tuple[int, ...] | None = None) -> Effect:
    """A law at a place with parameters from its ranges; its size is a first guess."""
    place = law.places[random.integers(len(law.places))] if place is None else place
    parameters = {name: parameter(*bounds, random, law.size != name) for name, bounds in law.ranges.items()}
    parameters[law.size] = math.sqrt(math.prod(law.ranges[law.size]))
    return Effect(law.family, tuple(JOINTS[i] for i in place), law.name, parameters)


def hidden(case: Case, effects: tuple[Effect, ...]) -> Case | None:
    """The case with effects scaled each to its strength; None if that fails, or the company swallows one."""
    sizer, sized = Sizer(case), []
    for one in effects:
        if (found := sizer.sized(one)) is None:
            return None
        sized.append(found)
    reached = (sized[0].fit.gap,)
    if len(sized) > 1:
        reached = sizer.together(sized)
        if min(reached[1:]) < 0.5 * case.strength:
            return None
    found = tuple(one.effect for one in sized)
    return replace(case, effects=found, reached=reached, step=min(LAWS[one.law].step for one in found))


def parameter(low: float, high: float, random: np.random.Generator, may_leave: bool) -> float:
    """From a range, log-uniformly where it is positive; sometimes beyond it."""
    if low <= 0.0:
        return float(random.uniform(low, high))
    widen = 3.0 if may_leave and random.random() < BEYOND else 1.0
    return float(np.exp(random.uniform(math.log(low), math.log(high)))) * float(np.exp(random.uniform(-1, 1) * math.log(widen)))


def _single(case: Case, random: np.random.Generator) -> Case | None:
    names = families()
    options = laws_of(names[case.seed % len(names)])
    return hidden(case, (effect(options[case.seed // len(names) % len(options)], random),))


def _several(count: int) -> Callable[[Case, np.random.Generator], Case | None]:
    def drawn(case: Case, random: np.random.Generator) -> Case | None:
        chosen = [effect(_any(family, random), random) for family in random.choice(families(), count, replace=False)]
        return hidden(case, tuple(chosen)) if _fit_together(chosen) else None

    return drawn


def _outside(case: Case, random: np.random.Generator) -> Case | None:
    options = laws_of(OUTSIDE)
    return hidden(case, (effect(options[case.seed % len(options)], random),))


def _twins(case: Case, random: np.random.Generator) -> Case | None:
    case, family, place = twin(case, random)
    return hidden(case, (effect(_any(family, random), random, place),))


def _any(family: str, random: np.random.Generator) -> Law:
    options = laws_of(family)
    return options[random.integers(len(options))]


def _fit_together(effects: list[Effect]) -> bool:
    """Not two laws on one joint that both need the leg's way between actuator and hip, and one law of the tips."""
    taken = [joint for one in effects if LAWS[one.law].machine == "series" or one.family == "configuration_dependent_transmission"
             for joint in one.joints]  # fmt: skip
    return len(taken) == len(set(taken))


GROUPS: dict[str, Callable[[Case, np.random.Generator], Case | None]] = {
    "single": _single,
    "pair": _several(2),
    "triple": _several(3),
    "null": null,
    "outside": _outside,
    "twins": _twins,
}
