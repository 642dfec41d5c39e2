"""What the workflow answers, as plain data: the shapes of `hamr gap --json` (design of the command line)."""

from __future__ import annotations

from dataclasses import dataclass, field

VERDICTS = ("no_significant_gap", "parameters_only", "named", "ambiguous", "unknown")


@dataclass(frozen=True)
class Estimate:
    """A parameter in SI with a 95 % interval."""

    value: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class NamedEffect:
    """An effect at its place: joints by name, parameters at each (`parameters["level"]["fl_swing"]`)."""

    effect: str
    form: str
    joints: tuple[str, ...]
    parameters: dict[str, dict[str, Estimate]]


@dataclass(frozen=True)
class Answer:
    """Effects that together are one possible answer.

    Attributes:
        left: of the gap, on readings that were not fitted. forms: the same for every form that was fitted of these names.
        unknown: whether a law outside the library is beside them; alone, where there are none.
    """

    effects: tuple[NamedEffect, ...]
    probability: float
    left: float
    forms: dict[str, float] = field(default_factory=dict)
    unknown: bool = False


@dataclass(frozen=True)
class Gap:
    """Rms of simulation minus measurement over all channels, in units of the floor.

    Attributes:
        raw: as given. retuned: after the re-tune. after: with the effects of the first answer. floor: sensor noise (1 by definition) with
            the simulation's own error. per_channel: channel -> the same three, in SI.
    """

    raw: float
    retuned: float
    after: float
    floor: float
    per_channel: dict[str, dict[str, float]]


@dataclass(frozen=True)
class Verdict:
    """The whole answer for one machine.

    Attributes:
        machine, joints: names. verdict: one of VERDICTS. set: the credible set, most probable first.
        parameters: name -> joint -> change that the re-tune made. gap. where: one sentence each, where the gap is.
        not_observable: effect -> why this run cannot show it. detectable: effect -> joint -> size (SI, with unit) that would be seen.
        experiment: what would decide, or None. notes: what to know besides (degeneracies, poor data).
    """

    machine: str
    joints: tuple[str, ...]
    verdict: str
    set: tuple[Answer, ...]
    parameters: dict[str, dict[str, Estimate]]
    gap: Gap
    where: tuple[str, ...]
    not_observable: dict[str, str]
    detectable: dict[str, dict[str, str]]
    experiment: dict | None
    notes: tuple[str, ...] = field(default=())
