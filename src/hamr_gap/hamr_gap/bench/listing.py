"""One line a case, beside the shares: what was hidden, and what was answered."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Set
from pathlib import Path

import numpy as np

from hamr_description.errors import ConfigError

from .score import Scored

VERDICT = ("case", "group", "hidden", "verdict", "first", "probability", "right", "in_set", "left", "seconds")
DATA = ("strength", "recorded_s", "noise")
COLUMNS = VERDICT + DATA


def write(path: Path, cases: Iterable[Scored]) -> None:
    """A CSV with a header.

    hidden and first: names at their joints; hidden: of a law outside the library the generator's name, for cases of one law belong
    together; first: "unknown" for such a law, empty where nothing is said to be missing.
    probability: of the first answer. right: whether the first answer is what was hidden, unknown of what no library has, and nothing of
    nothing (0, 1). in_set: whether the set holds it.
    left: mean square that the best names leave, in units of the noise. seconds: of a processor.
    strength: that all effects together reach, in floors. recorded_s: length of the record, s. noise: standard deviation of the
    encoders', as a share of the stroke.
    """
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(COLUMNS)
        for case in sorted(cases, key=lambda c: c.name):
            first = said(case.first) if case.answers else ""
            probability = f"{case.result['weights'][0]['probability']:.3f}" if case.answers else ""
            left = f"{case.result['best']:.3f}" if "best" in case.result else ""
            out.writerow([
                case.name, case.group, hidden(case), case.verdict, first, probability, int(right(case)), int(case.covered), left,
                f"{case.result['seconds']:.0f}", *data(case),
            ])  # fmt: skip


def read(path: Path, needed: tuple[str, ...] = VERDICT) -> list[dict[str, str]]:
    """Lines of a listing; ConfigError if it has not the columns that are needed."""
    with path.open(newline="") as file:
        lines = list(csv.DictReader(file))
    if not lines or not set(VERDICT) <= set(lines[0]):
        raise ConfigError(f"{path} is no listing of the benchmark; `hamr gap bench` writes them, as verdicts.csv.")
    if missing := ", ".join(column for column in needed if column not in lines[0]):
        raise ConfigError(f"{path} does not say {missing}; the same `hamr gap bench` writes it anew and solves nothing twice.")
    return lines


def data(case: Scored) -> tuple[str, str, str]:
    """DATA of a case, as text; an answer says first what all effects reach together, and nothing of a null."""
    values = (case.answer[key] for key in ("reached", "seconds", "noise"))
    return tuple("".join(f"{x:.4g}" for x in np.ravel(value)[:1]) for value in values)


def right(case: Scored) -> bool:
    """Whether the verdict is what it should be."""
    if case.group == "outside":
        return case.verdict == "unknown"
    return case.exact if case.truth else not case.answers


def hidden(case: Scored) -> str:
    """What was hidden, at its joints."""
    return said({(case.law, joints) for _, joints in case.truth} if case.group == "outside" else case.truth)


def said(effects: Set | None) -> str:
    """Names at their joints: "backlash (fl_lift) + drive_lag (fl_swing)"; "unknown" for None."""
    if effects is None:
        return "unknown"
    return " + ".join(f"{name} ({', '.join(joints) or 'all'})" for name, joints in sorted(effects))
