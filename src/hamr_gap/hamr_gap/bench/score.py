"""From answers and verdicts to scores with 95 % intervals."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hamr_description.names import JOINTS

from ..judging.weigh import COVERAGE
from .rates import rate

GROUND = ("ground", "ground_null")


@dataclass(frozen=True)
class Scored:
    """A case: its answer, the verdict and how they agree."""

    name: int
    group: str
    truth: frozenset
    verdict: str
    first: frozenset | None
    answers: tuple[frozenset | None, ...]
    result: dict
    answer: dict

    @property
    def exact(self) -> bool:
        """The first answer has the right families at the right places."""
        return self.verdict in ("named", "ambiguous") and self.first == self.truth

    @property
    def law(self) -> str:
        """What was hidden in it, by the generator's names: cases of one law may be right or wrong together. A null is its own."""
        return " + ".join(sorted(e["law"] for e in self.answer["effects"])) or str(self.name)

    @property
    def covered(self) -> bool:
        """The credible set holds the right answer."""
        return self.truth in self.answers


def kept_in(out: Path, verdicts: str, way: str) -> Path:
    """Where lies what belongs to verdicts: others about the same cases ("second", with the run asked for, "noise", "half"), "decidable"."""
    return out / f"{verdicts}_{way}"


def names(effects: Iterable) -> frozenset:
    """Families and places; all joints are the whole robot, as none are."""
    return frozenset((effect, () if set(joints) == set(JOINTS) else tuple(sorted(joints))) for effect, _, joints in effects)


def families(found: frozenset) -> set[str]:
    """Families without places."""
    return {family for family, _ in found}


def scored(folder: Path, name: int, verdicts: str = "verdicts") -> Scored:
    """One case."""
    answer = json.loads((folder / "answers" / f"{name}.json").read_text())
    result = json.loads((folder / verdicts / f"{name}.json").read_text())
    truth = names((e["family"], e["law"], e["joints"]) for e in answer["effects"])
    chosen, total = [], 0.0
    for w in result["weights"]:
        chosen.append(None if w["effects"] is None else names(w["effects"]))
        total += w["probability"]
        if total >= COVERAGE:
            break
    found = result["verdict"] in ("named", "ambiguous", "unknown")
    return Scored(
        name, answer["group"], truth, result["verdict"],
        chosen[0] if found and chosen else None, tuple(chosen) if found else (), result, answer,
    )  # fmt: skip


def share(cases: Iterable[Scored], what: Callable[[Scored], bool]) -> str:
    """Of how many cases something holds, with an interval that knows the laws they have in common."""
    cases = list(cases)
    return rate([what(c) for c in cases], [c.law for c in cases])


def table(cases: Iterable[Scored]) -> list[tuple[str, str]]:
    """Rows of the scoreboard: of legs, and of robots on the ground where there are any."""
    cases = list(cases)
    legs = [c for c in cases if c.group not in GROUND]
    walks = [replace(c, group="null" if c.group == "ground_null" else "single") for c in cases if c.group in GROUND]
    own = [(f"on the ground: {what}", value) for what, value in _rows(walks) if value != "-"] if walks else []
    return [*(_rows(legs) if legs or not walks else []), *own]


def _rows(cases: list[Scored]) -> list[tuple[str, str]]:
    of = {group: [c for c in cases if c.group == group] for group in ("single", "pair", "triple", "null", "outside", "twins")}
    known = [*of["single"], *of["pair"], *of["triple"]]
    sets = [c for c in known if c.answers]
    changed = [c for c in of["null"] if c.answer["changes"]]
    rows = [
        ("singles: exact name and place", share(of["single"], lambda c: c.exact)),
        ("singles: right name, any place", share(of["single"], lambda c: c.first is not None and families(c.first) == families(c.truth))),
        ("pairs: exact", share(of["pair"], lambda c: c.exact)),
        ("triples: exact", share(of["triple"], lambda c: c.exact)),
        ("twins: exact", share(of["twins"], lambda c: c.exact)),
        ("nulls: false alarms", share(of["null"], lambda c: c.verdict in ("named", "ambiguous", "unknown"))),
        ("nulls with changes: parameters_only", share(changed, lambda c: c.verdict == "parameters_only")),
        ("outside the library: called unknown", share(of["outside"], lambda c: c.verdict == "unknown")),
        ("outside the library: confident and wrong", share(of["outside"], lambda c: c.verdict == "named")),
        ("known ones called unknown", share(known, lambda c: c.verdict == "unknown")),
        ("known ones: confident and wrong", share(known, lambda c: c.verdict == "named" and not c.exact)),
        ("known ones missed (no gap, or parameters only)", share(known, lambda c: c.verdict in ("no_significant_gap", "parameters_only"))),
        ("90 % sets hold the answer", share(sets, lambda c: c.covered)),
        ("mean size of sets", f"{np.mean([len(c.answers) for c in sets]):.2f}" if sets else "-"),
    ]
    shrunk = [closed(c) for c in known if closed(c) is not None]
    if shrunk:
        rows.append(("share of the gap closed on untouched readings: median, 10th percentile",
                     f"{np.median(shrunk):.3f}, {np.percentile(shrunk, 10):.3f}"))  # fmt: skip
    seconds = [c.result["seconds"] for c in cases]
    used = f"{np.median(seconds):.1f}, {np.percentile(seconds, 90):.1f}" if seconds else "-"
    rows.append(("processor seconds: median, 90th percentile", used))
    return rows


def closed(case: Scored) -> float | None:
    """Mean square removed by the first answer over what the re-tune leaves above the noise, on the readings of role `report`."""
    if not case.first or "report" not in case.result:
        return None
    base, best, floor = (case.result["report"][k] for k in ("base", "best", "floor"))
    return float((base - best) / (base - floor)) if base > 1.5 * floor else None
