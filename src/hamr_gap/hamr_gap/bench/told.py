"""Scores beside names: intervals against the library's own fit of the noise-free truth, computed ambiguity, and experiments made."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..judging.weigh import DECIDES, within
from . import decidable
from .other import WAYS
from .rates import rate
from .score import GROUND, Scored, kept_in, names, scored, share

TOLD_APART = (2.0 * DECIDES) ** 0.5  # d' from which data tell two laws apart


def rows(out: Path, cases: Sequence[Scored], verdicts: str) -> list[tuple[str, str]]:
    """Rows of the scoreboard for what was looked into."""
    ideals = {c.name: json.loads(path.read_text()) for c in cases if (path := out / "ideals" / f"{c.name}.json").exists()}
    known = [c for c in cases if c.truth and c.name in ideals]
    rivals = {c.name: right_set(c.truth, ideals[c.name]["rivals"]) for c in known}
    blurred = [c for c in known if len(rivals[c.name]) > 1]
    again = [(a, b) for a, b in _pairs(out, cases, verdicts, "second") if a.covered]
    noise, half = (_pairs(out, cases, verdicts, way) for way in WAYS)
    shown = [(c, path) for c in unsure(cases) if (path := kept_in(out, verdicts, decidable.WAY) / f"{c.name}.json").exists()]
    apart = [(c, max(json.loads(path.read_text()).values()) >= TOLD_APART) for c, path in shown]
    told_apart, not_told = ([c for c, yes in apart if yes == wanted] for wanted in (True, False))
    settled = {a.name for a, b in again if b.verdict == "named" and b.exact}
    holds = [(hit, c.law) for c in known for hit in held(c, ideals[c.name]["forms"])]
    found = [
        ("95 % intervals that hold the truth", rate(*zip(*holds, strict=True)) if holds else "-"),
        ("cases that these data cannot tell (computed)", share(known, lambda c: len(rivals[c.name]) > 1)),
        ("of these: called ambiguous, the answer in the set", share(blurred, lambda c: c.verdict == "ambiguous" and c.covered)),
        ("of these: confident and wrong", share(blurred, lambda c: c.verdict == "named" and not c.exact)),
        ("ambiguous: settled by the run that was asked for", share((a for a, _ in again), lambda c: c.name in settled)),
        ("ambiguous and decidable (computed): settled by the run that was asked for", share(told_apart, lambda c: c.name in settled)),
        ("ambiguous and not decidable (computed): it was said that no experiment decides", share(not_told, _silent)),
        ("same answer with other noise", _agree(noise)),
        ("same answer from half of the data", _agree(half)),
    ]
    return [(name, text) for name, text in found if text != "-"]


def unsure(cases: Sequence[Scored]) -> list[Scored]:
    """Legs with an ambiguous answer that holds the right names."""
    return [c for c in cases if c.group not in GROUND and c.verdict == "ambiguous" and c.covered]


def _silent(case: Scored) -> bool:
    return bool(case.result["experiment"]) and not case.result["experiment"]["signal"]


def _pairs(out: Path, cases: Sequence[Scored], verdicts: str, way: str) -> list[tuple[Scored, Scored]]:
    """Cases with what was said of them from another run."""
    folder = kept_in(out, verdicts, way)
    return [(c, scored(out, c.name, folder.name)) for c in cases if (folder / f"{c.name}.json").exists()]


def _agree(pairs: Sequence[tuple[Scored, Scored]]) -> str:
    return rate([same(a, b) for a, b in pairs], [a.law for a, _ in pairs])


def same(a: Scored, b: Scored) -> bool:
    """Whether two verdicts have the same first name, or none for the same reason."""
    named = ("named", "ambiguous")
    return a.first == b.first and (a.verdict == b.verdict or {a.verdict, b.verdict} <= set(named))


def right_set(truth: frozenset, rivals: Sequence) -> set[frozenset]:
    """The truth and all that noise-free data do not tell from it, without what only adds to another member or has it as a special case."""
    close = {truth, *(names(effects) for effects, d in rivals if effects and d < TOLD_APART)}
    return {some for some in close if some == truth or not any(_wider(some, other) for other in close if other != some)}


def _wider(some: frozenset, other: frozenset) -> bool:
    """Whether names have others as a special case: they are more, or at more joints, or their laws contain the others'."""
    return some != other and len(other) <= len(some) and all(any(within(effect, wide) for wide in some) for effect in other)


def held(case: Scored, forms: dict) -> Iterator[bool]:
    """Whether each parameter's interval of the first answer holds what its form has on noise-free data."""
    if not case.exact or not case.result["set"]:
        return
    effects = case.result["set"][0]["effects"]
    ideal = forms.get(" + ".join(e["form"] for e in effects), ())
    by_effect = {e["effect"]: e["parameters"] for e in ideal}
    for effect in effects:
        for name, joints in by_effect.get(effect["effect"], {}).items():
            for joint, best in joints.items():
                found = effect["parameters"][name][joint]
                yield found["low"] <= best["value"] <= found["high"]
