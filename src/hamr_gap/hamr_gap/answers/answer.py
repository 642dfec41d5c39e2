"""Answers about several machines (the legs of a robot) as one: the shape of `verdict.json` and of `hamr gap --json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.places import WORDS

from ..judging.verdict import VERDICTS
from .found import Found
from .together import Combination

SCALE_NOTE = (
    "Drive and angle fix inertia, stiffness, damping and gain only up to one common factor: a weaker drive and a machine that is heavier, "
    "stiffer and more damped look the same; a known added mass or a load cell tells them apart."
)


def answer(founds: Mapping[str, Found], combinations: Sequence[Combination], refused: Mapping[str, str] | None = None) -> dict:
    """One answer.

    Args:
        founds, combinations: of `together`. refused: machine or bag -> why nothing can be said about it, in one sentence.

    Returns:
        verdict: that of the machine about which least is sure, or of all together where each misses something.
        set: [{effects: [{effect, form, place, parameters}], probability}], of all machines together, equal names merged.
        parameters: the re-tune. gap: rms in floors, over all machines, and per channel in SI.
        where, not_observable, experiment, notes; machines: each one's own verdict; refused.
    """
    own = {name: found.verdict for name, found in founds.items()}
    silent = {effect: why for v in own.values() for effect, why in v["not_observable"].items()}
    told = all(len(v["joints"]) == 1 and "gain" in v["parameters"] for v in own.values())  # a single joint's, where it is free at all
    experiments = {name: v["experiment"] for name, v in own.items() if v["experiment"]}
    return {
        "verdict": _verdict(founds, combinations),
        "set": [_combined(founds, c) for c in combinations],
        "parameters": [
            {"name": name, "joint": joint, **estimate}
            for v in own.values() for name, joints in v["parameters"].items() for joint, estimate in joints.items()
        ],
        "gap": _gap([v["gap"] for v in own.values()]),
        "where": [sentence for v in own.values() for sentence in v["where"]],
        "not_observable": [{"effect": effect, "why": why, "shown_by": library()[effect].experiment} for effect, why in silent.items()],
        "experiment": experiments or None,
        "notes": list(dict.fromkeys([*(note for v in own.values() for note in v["notes"]), *([] if told else [SCALE_NOTE])])),
        "machines": {name: v | {"tried": founds[name].tried} for name, v in own.items()},
        "refused": dict(refused or {}),
    }  # fmt: skip


def place_of(joints: Sequence[str]) -> str:
    """What joints have in common: "fl_swing", "fl", "swing" (all four), "all"; else their names; of none, "chassis"."""
    words = {frozenset(found): word for word, found in reversed(WORDS.items())} | {frozenset(): "chassis"}
    return words.get(frozenset(joints), ", ".join(joints))


def merged(effects: Sequence[Mapping]) -> list[dict]:
    """Effects of all machines with equal names as one: its place, and of each parameter the median with the hull of the intervals, and
    what it is `at` each joint."""
    groups: dict[tuple[str, str], list[Mapping]] = {}
    for effect in effects:
        groups.setdefault((effect["effect"], effect["form"]), []).append(effect)
    result = []
    for (name, form), members in groups.items():
        parameters: dict[str, dict] = {}
        for key in members[0]["parameters"]:
            each = {joint: estimate for member in members for joint, estimate in member["parameters"][key].items()}
            values = list(each.values())
            parameters[key] = {
                "value": float(np.median([v["value"] for v in values])), "unit": values[0]["unit"],
                "low": min(v["low"] for v in values), "high": max(v["high"] for v in values),
            }  # fmt: skip
            if len(values) > 1:
                parameters[key]["at"] = each
        joints = [joint for member in members for joint in member["joints"]]
        result.append({"effect": name, "form": form, "place": place_of(joints), "joints": joints, "parameters": parameters})
    return result


def _verdict(founds: Mapping[str, Found], combinations: Sequence[Combination]) -> str:
    if not combinations or len(combinations[0].numbers) < len(founds):
        return max((f.verdict["verdict"] for f in founds.values()), key=VERDICTS.index)
    first = (founds[name].answers[k] for name, k in combinations[0].numbers.items())
    return "unknown" if any(a["unknown"] for a in first) else "named" if len(combinations) == 1 else "ambiguous"


def _combined(founds: Mapping[str, Found], combination: Combination) -> dict:
    """The machines' answers as one; `unknown` is in how many a law outside the library is."""
    answers = [founds[name].answers[k] for name, k in combination.numbers.items()]
    return {
        "effects": merged([e for a in answers for e in a["effects"]]), "probability": combination.probability,
        "unknown": sum(a["unknown"] for a in answers), "forms": {form: left for a in answers for form, left in a["forms"].items()},
    }  # fmt: skip


def _gap(gaps: Sequence[Mapping]) -> dict:
    over = {key: float(np.sqrt(np.mean([g[key] ** 2 for g in gaps]))) for key in ("raw", "retuned", "after", "floor")}
    return over | {"per_joint": {channel: values for g in gaps for channel, values in g["per_channel"].items()}}
