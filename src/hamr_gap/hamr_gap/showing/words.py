"""A verdict in plain sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..judging.part import NEEDED
from ..judging.table import TABLE

COMMON = ("coulomb_friction", "cubic_stiffness", "backlash", "drive_lag")  # whose smallest visible size is said
OVER = 1.5  # times the noise: as much may have a cause, though none was found
UNNAMED = ("no_significant_gap", "parameters_only")
FEW = 2  # sensors, of which what is left is said one by one
MOST = 3  # answers, and parameters of each effect, that are said
HEADLINES = {
    "no_significant_gap": "No significant gap: the model explains these data to within their noise.",
    "parameters_only": "No effect is missing: other parameters of the same model close the gap.",
    "named": "An effect is missing, and it has a name.",
    "ambiguous": "An effect is missing; these data leave more than one name.",
    "unknown": "Something is missing that is not in the library.",
}
OUTSIDE = "a law outside the library"
IN_PART = "Part of what is missing has a name; beside it something is missing that is not in the library."


def sentences(found: Mapping) -> list[str]:
    """What `verdict.json` says, most important first."""
    said = [_headline(found)]
    for i, answer in enumerate(found["set"][:MOST]):
        start = "Or" if i else "Most probable" if len(found["set"]) > 1 else "It is"
        said.append(f"{start} (probability {answer['probability']:.2f}): {answer_in_words(answer)}.")
    if _in_part(found):
        said.append(f"Whatever was tried without that name, or one like it, leaves more than {NEEDED:g} times as much of the gap.")
    if len(found["set"]) > MOST:
        said.append(f"And {len(found['set']) - MOST} more, in the report.")
    if len(found["set"]) > 1 and (common := _in_all(found["set"])):
        said.append(f"In all of them: {', '.join(common)}.")
    if found["verdict"] == "parameters_only":
        said += _retuned(found["parameters"])
    tables = [e for own in found["machines"].values() for e in own["added"] if e["effect"] == TABLE]
    said += [
        f"What acts there, as a table: {e['form'].replace('_', ' ')} at {', '.join(e['joints'])} (in the report and the effects file)."
        for e in tables
    ]
    said += [f"What comes nearest at {name}: {_nearest(own['tried'])}." for name, own in found["machines"].items() if _lacks(own)]
    if shown := found.get("shown"):
        over, share, added = shown["over_floor"], shown["closed"], any(own["added"] for own in found["machines"].values())
        after = f", {over['after']:.2f} with what was found" if added else ""
        said.append(f"Simulation minus measurement, in units of the sensor noise, on {shown['data']}: {over['raw']:.2f} as given, "
                    f"{over['retuned']:.2f} re-tuned{after}.")  # fmt: skip
        said += _in_units(shown["machines"], ("raw", "retuned", *["after"] * added))
        if added and share is not None:
            gone = f"{100 * share:.1f} % of the re-tuned gap is gone" if share > 0.0 else "What was found does not hold there"
            said.append(f"{gone}; taken out again, it is {over['removed']:.2f}.")
    if not found["set"]:
        said += [f"{name} would have shown {some}." for name, v in found["machines"].items() if (some := _smallest(v["detectable"]))]
        said += [f"{name}: {note}" for name, v in found["machines"].items() for note in v["notes"]]
    said += [f"{name}: {why}" for name, why in found["refused"].items()]
    for name, experiment in (found["experiment"] or {}).items():
        said.append(f"What would decide about {name}: {experiment['sentence']}")
    return said


def _headline(found: Mapping) -> str:
    """That of the verdict; but where nothing was found, though more than noise is left, how much that is."""
    times = {name: own["gap"]["retuned"] / own["gap"]["floor"] for name, own in found["machines"].items() if _unsaid(own)}
    if found["set"] or not times:
        return IN_PART if _in_part(found) else HEADLINES[found["verdict"]]
    left = ", ".join(f"{x:.1f} times the noise at {name}" for name, x in times.items())
    return f"No effect is surely missing, but something is not explained: the re-tuned model leaves {left}."


def _in_all(answers: Sequence[Mapping]) -> list[str]:
    """Effects that no answer is without, wherever they are."""
    names = [{e["effect"] for e in answer["effects"]} for answer in answers]
    return sorted(set.intersection(*names))


def _in_part(found: Mapping) -> bool:
    """Whether some machine's own answer is a name beside an unknown law: another's name is no part of it."""
    own = (answer for own in found["machines"].values() for answer in own["set"])
    return found["verdict"] == "unknown" and any(answer["unknown"] and answer["effects"] for answer in own)


def _retuned(parameters: Sequence[Mapping]) -> list[str]:
    """Which parameters surely changed, the surest first: who knows the machine can tell whether they may, or stand in for an effect."""
    sure = [p for p in parameters if p["low"] * p["high"] > 0.0]
    sure.sort(key=lambda p: (p["high"] - p["low"]) / abs(p["high"] + p["low"]))
    shown = [f"{p['name']} of {p['joint']} by {estimates(_in_percent(p))}" for p in sure[:MOST]]
    more = [f"and {len(sure) - MOST} more, in the report"] if len(sure) > MOST else []
    return [f"A re-tune changes {', '.join([*shown, *more])}."] if sure else []


def _in_percent(parameter: Mapping) -> Mapping:
    """A relative change in percent."""
    if parameter["unit"] != "1":
        return parameter
    return parameter | {x: 100.0 * parameter[x] for x in ("value", "low", "high")} | {"unit": "%"}


def _unsaid(own: Mapping) -> bool:
    return own["verdict"] in UNNAMED and own["gap"]["retuned"] > OVER * own["gap"]["floor"]


def _in_units(machines: Mapping, states: Sequence[str]) -> list[str]:
    """The same of each sensor of a single machine, if it has few."""
    channels = {channel: x for own in machines.values() for channel, x in own["channels"].items()}
    if len(machines) > 1 or len(channels) > FEW:
        return []
    each = [f"{', '.join(number(x[state]) for state in states)}{unit(x['unit'])} at {channel}" for channel, x in channels.items()]
    return [f"In the sensors' own units, likewise: {'; '.join(each)}."]


def _lacks(own: Mapping) -> bool:
    return bool(own["tried"]) and (own["verdict"] == "unknown" or _unsaid(own))


def _nearest(tried: Sequence[Mapping]) -> str:
    """What the best one effect, the best two and so on leave of the gap, while more leave less."""
    best: list[Mapping] = []
    for row in sorted(tried, key=lambda row: (row["count"], row["left"])):
        if not best or (row["count"] > best[-1]["count"] and row["left"] < best[-1]["left"]):
            best.append(row)
    return "; ".join(f"{row['effects']} leaves {100 * row['left']:.0f} % of the gap" for row in best)


def _smallest(detectable: Mapping[str, Mapping[str, str]]) -> str:
    """The least sizes of a few common effects that a machine's data would have shown."""
    known = [name for name in COMMON if name in detectable]
    return ", ".join(f"{name} of {size} at {joint}" for name in known for joint, size in list(detectable[name].items())[:1])


def answer_in_words(answer: Mapping) -> str:
    """Effects, places and parameters of one answer."""
    parts = [f"{e['effect']} ({e['form']}) at {e['place']}, {_parameters(e)}" for e in answer["effects"]]
    if answer["unknown"]:
        parts.append(OUTSIDE)
    return " and ".join(parts)


def _parameters(effect: Mapping) -> str:
    shown = [f"{name} {estimates(x)}" for name, x in effect["parameters"].items()]
    return ", ".join([*shown[:MOST], *(["..."] if len(shown) > MOST else [])])


def estimates(x: Mapping) -> str:
    """A parameter with its interval, of each joint by itself where those of two have nothing in common."""
    at = x.get("at", {})
    if len(at) == 2 and max(v["low"] for v in at.values()) > min(v["high"] for v in at.values()):
        return " and ".join(f"{estimates(v)} at {joint}" for joint, v in at.items())
    return f"{number(x['value'])} ({number(x['low'])} to {number(x['high'])}){unit(x['unit'])}"


def number(x: float) -> str:
    """Three digits."""
    return f"{x:.3g}"


def unit(name: str) -> str:
    """A unit behind a number; a ratio has none."""
    return "" if name == "1" else f" {name}"
