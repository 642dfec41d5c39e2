"""Drawing cases that walk: a seed gives one, always the same."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hamr_description.errors import ConfigError, ModelError
from hamr_description.names import AXES, JOINTS

from ..case import Effect
from ..conditions import changes
from ..draw import parameter
from ..laws.law import BOTH, LAWS, Law
from ..sizing import search
from .case import KINDS, GroundCase, conditions
from .laws import GroundLaw, families, laws_of
from .retune import left
from .strength import shown, walked

#: What is hidden in the cases of a group, by turns with the seed.
GROUPS = {"ground": families(), "ground_null": ("nothing", "changes")}
AXIS = {axis: tuple(joint for joint in JOINTS if joint.endswith(axis)) for axis in AXES}
ATTEMPTS = 20
SPARE = 88  # apart from the groups of draw.GROUPS
#: Seconds of the brief run on which a size is sought, how near it must come before a re-tune, and trials on it and on the whole run.
BRIEF, NEAR, TRIALS, WHOLE_TRIALS = 2.0, 0.1, 8, 4
#: Times that a robot is tuned at most, and how near the strength what it leaves must come, as a logarithm.
RETUNES, AFTER = 4, math.log(1.1)


def turn(group: str, seed: int) -> str:
    """What the case of a group and seed hides: a name, or what a null does instead."""
    return GROUPS[group][seed % len(GROUPS[group])]


def draw(group: str, seed: int, *, strength: float = 5.0, seconds: float = 12.0) -> GroundCase:
    """Draw a case.

    Args:
        group: one of GROUPS. seed: equal arguments give equal cases; `turn(group, seed)` is hidden.
        strength: rms over segments of 20 ms of the run minus that of the best tuned robot without the effect from the same states, in
            floors of the sensor noise, in the channel (hip angle, axis of position or orientation) that shows it most.
        seconds: length of the run, 1 to 12.

    Returns:
        A case that reaches the strength within 10 %. ConfigError if no draw does.
    """
    if group not in GROUPS:
        raise ConfigError(f"There is no group '{group}' of cases on the ground; choose one of {', '.join(GROUPS)}.")
    hides = turn(group, seed)
    for attempt in range(ATTEMPTS):
        random = np.random.default_rng([SPARE, seed, attempt])
        case = conditions(group, seed, strength, seconds, random)
        try:
            if group == "ground_null":
                case = replace(case, changes=changes(random, JOINTS, KINDS) if hides == "changes" else {})
                case.run()  # must not fall over
                return case
            options = laws_of(hides)
            if found := _sized(case, _effect(options[seed // len(GROUPS[group]) % len(options)], random)):
                return found
        except ModelError:
            continue
    raise ConfigError(f"No case on the ground of seed {seed} hides '{hides}' with strength {strength}; ask for less.")


def _effect(law: GroundLaw | Law, random: np.random.Generator) -> Effect:
    """A law of all legs or the body, parameters from its ranges; its size is a first guess.

    What a whole leg cannot show, all legs cannot either: a delay of all drives is one of the clock, so it is at one axis.
    """
    parameters = {name: parameter(*bounds, random, law.size != name) for name, bounds in law.ranges.items()}
    parameters[law.size] = math.sqrt(math.prod(law.ranges[law.size]))
    joints = () if law.name not in LAWS else JOINTS if BOTH in law.places else AXIS[random.choice(AXES)]
    return Effect(law.family, joints, law.name, parameters)


def _sized(case: GroundCase, effect: Effect) -> GroundCase | None:
    """The case with the effect scaled to its strength; None if the bounds forbid that. ModelError if the robot falls.

    What shows before a re-tune costs little to know, and rises with the size; what is left after one is a share of it that hardly changes.
    """
    law = next(law for law in laws_of(effect.family) if law.name == effect.law)
    low, high = map(math.log, law.ranges[law.size])

    def of(size: float) -> Effect:
        return replace(effect, parameters=effect.parameters | {law.size: math.exp(size)})

    def channels(size: float, seconds: float, measured: Callable) -> dict[str, float]:
        volts = case.volts(seconds)
        return measured(walked((of(size),), case.changes, volts), case.changes, volts, case.floors)

    x, slope, goal = math.log(effect.parameters[law.size]), 1.0, case.strength
    stages = ((min(BRIEF, case.seconds), TRIALS), (case.seconds, WHOLE_TRIALS))
    for _ in range(RETUNES):
        for seconds, trials in stages:

            def miss(size: float, seconds=seconds, goal=goal) -> float:
                return math.log(max(*channels(size, seconds, shown).values(), 1e-6) / goal)

            at, y, slope = search(miss, x, slope, low, high, NEAR, trials)
            x = min(max(at - y / slope, low), high)
        if not low < at < high:
            return None
        after = channels(at, case.seconds, left)
        off = math.log(max(after.values()) / case.strength)
        if abs(off) < AFTER:
            return replace(case, effects=(of(at),), channels=after, reached=max(after.values()))
        goal, x, stages = goal * math.exp(-off), min(max(at - off / slope, low), high), stages[-1:]
    return None
