"""One line a case, beside the shares: what was hidden, and what was answered."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Set
from pathlib import Path

from .score import Scored

COLUMNS = ("case", "group", "hidden", "verdict", "first", "probability", "right", "in_set", "left", "seconds")


def write(path: Path, cases: Iterable[Scored]) -> None:
    """A CSV with a header.

    hidden and first: names at their joints; hidden: of a law outside the library the generator's name, for cases of one law belong
    together; first: "unknown" for such a law, empty where nothing is said to be missing.
    probability: of the first answer. right: whether the first answer is what was hidden, unknown of what no library has, and nothing of
    nothing (0, 1). in_set: whether the set holds it.
    left: mean square that the best names leave, in units of the noise. seconds: of a processor.
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
                f"{case.result['seconds']:.0f}",
            ])  # fmt: skip


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
