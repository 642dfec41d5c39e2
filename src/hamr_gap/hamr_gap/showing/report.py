"""The report: one HTML file with everything inside, for any browser without a network."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from io import BytesIO
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from hamr_description.names import ACTUATORS

from . import plots
from .words import OUTSIDE, number, sentences, unit

CSS = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; } h2 { font-size: 1.15rem; margin-top: 2.2rem; border-bottom: 1px solid #ddd; }
h3 { font-size: 1rem; margin-bottom: .3rem; } table { border-collapse: collapse; margin: .6rem 0; }
td, th { padding: .2rem .9rem .2rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid #eee; }
td { font-variant-numeric: tabular-nums; }
th { font-weight: 600; color: #555; } img { max-width: 100%; display: block; margin: .5rem 0 1rem; }
code { background: #f4f4f4; padding: .1rem .3rem; } .big li:first-child { font-weight: 600; } .quiet { color: #666; font-size: .9rem; }
"""


def write_report(found: Mapping, pictures: Mapping[str, plots.Arrays], path: Path) -> None:
    """Args: found, content of `verdict.json`; pictures, arrays of `show` by machine."""
    first, *rest = sentences(found)
    effect = bool(found["set"])
    states = ("raw", "retuned", "after", "removed") if effect else ("raw", "retuned")
    shown = found["shown"]
    body = [
        f"<h1>{escape(first)}</h1>",
        _list(rest, "big"),
        _set(found),
        "<h2>Before and after</h2>",
        f"<p>On {escape(shown['data'])}.</p>",
    ]
    body.append(_image(plots.gap_bars({name: s["over_floor"] for name, s in shown["machines"].items()}, states), "gap of each machine"))
    body += [_gaps(shown, states), _horizons(shown, states), "<h2>Where the gap is</h2>", _list(found["where"])]
    for name, own in found["machines"].items():
        if name in pictures:
            body += _machine(name, own, shown["machines"][name], pictures[name], effect=effect)
    body += [_changes(found), _visible(found), _silent(found), "<h2>To know besides</h2>", _list(found["notes"]), _files(found)]
    html = f"<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><title>{escape(first)}</title><style>{CSS}</style></head><body>"
    path.write_text(f"{html}{''.join(body)}</body></html>\n")


def _machine(name: str, own: Mapping, shown: Mapping, arrays: plots.Arrays, *, effect: bool) -> list[str]:
    units = {channel: values["unit"] for channel, values in shown["channels"].items()}
    pictured = {channel: u for channel, u in units.items() if channel not in ACTUATORS}  # which are the last
    states = ("raw", "retuned", "after") if effect else ("raw", "retuned")
    body = [f"<h2>{escape(name)}: {escape(own['verdict'].replace('_', ' '))}</h2>"]
    body.append("<h3>Measured and simulated, where the re-tuned model is worst</h3>")
    body.append(_image(plots.traces(arrays, pictured, states[1:] if effect else states), "readings over a short window"))
    body += ["<h3>Spectra of the difference</h3>", _image(plots.spectra(arrays, pictured, states), "spectra")]
    body += [
        "<h3>Difference over reading and rate</h3>",
        _image(plots.maps(arrays, pictured, states[1:]), "mean difference over readings and their rates"),
    ]
    if own["tried"]:
        right = [" + ".join(f"{e['effect']} ({', '.join(e['joints'])})" for e in a["effects"]) for a in own["set"]]
        body += ["<h3>What each name leaves of the gap</h3>", _image(plots.left_by_names(own["tried"], right), "gap left by each name")]
    tables = [e for e in own["added"] if e["effect"] == "force_table"]
    for table in tables:
        body += ["<h3>The law that was found, as a table</h3>", _image(plots.table_effect(table), "force found")]
    return body


def _set(found: Mapping) -> str:
    if not found["set"]:
        return ""
    rows = []
    for answer in found["set"]:
        for i, effect in enumerate([*answer["effects"], *[None] * bool(answer["unknown"])]):
            probability = f"{answer['probability']:.2f}" if i == 0 else ""
            if effect is None:
                rows.append([probability, OUTSIDE, "", "", "", ""])
                continue
            own = effect["parameters"].items()
            each = [(joint, name, x) for name, merged in own for joint, x in merged.get("at", {effect["place"]: merged}).items()]
            for k, (joint, name, x) in enumerate(each):
                head = [probability, f"{effect['effect']} ({effect['form']})"] if k == 0 else ["", ""]
                rows.append([*head, joint, name, number(x["value"]) + unit(x["unit"]), f"{number(x['low'])} to {number(x['high'])}"])
    return "<h2>What is missing</h2>" + _table(["probability", "effect", "place", "parameter", "value", "95 % interval"], rows)


def _gaps(shown: Mapping, states: Sequence[str]) -> str:
    rows = []
    for machine in shown["machines"].values():
        for channel, x in machine["channels"].items():
            rows.append([channel, *(number(x[state]) for state in states), number(x["noise"]), x["unit"]])
    return "<h3>Rms difference of each channel</h3>" + _table(["channel", *(plots.LOOK[s][1] for s in states), "noise", "unit"], rows)


def _horizons(shown: Mapping, states: Sequence[str]) -> str:
    rows = [[f"after {h}", *(f"{x[s]:.2f}" for s in states)] for h, x in shown["horizons"].items()]
    rows.append(["free run", *(f"{shown['over_floor'][s]:.2f}" for s in states)])
    about = (
        "<p class='quiet'>Runs that start anew from the measured motion; in units of the sensor noise, which is also in their start.</p>"
    )
    return "<h3>By horizon</h3>" + about + _table(["", *(plots.LOOK[s][1] for s in states)], rows)


def _changes(found: Mapping) -> str:
    rows = [
        [p["name"], p["joint"], number(p["value"]) + unit(p["unit"]), f"{number(p['low'])} to {number(p['high'])}"]
        for p in found["parameters"]
    ]
    about = "<p>What was added to the model's own parameters beside the effects (gain: relative).</p>"
    return "<h2>Re-tuned parameters</h2>" + about + _table(["parameter", "joint", "change", "95 % interval"], rows)


def _visible(found: Mapping) -> str:
    rows = [
        [effect, joint, size]
        for own in found["machines"].values() for effect, joints in own["detectable"].items() for joint, size in joints.items()
    ]  # fmt: skip
    about = (
        "<p>The smallest size of each effect alone that would have stood out, after a re-tune and beside what is left unexplained; for the "
        "simplest form of each name.</p>"
    )
    return "<h2>What these data would have shown</h2>" + about + _table(["effect", "joint", "smallest size"], rows)


def _silent(found: Mapping) -> str:
    if not found["not_observable"]:
        return ""
    rows = [[x["effect"], x["why"], x["shown_by"]] for x in found["not_observable"]]
    return "<h2>What these data cannot show</h2>" + _table(["effect", "because", "what would show it"], rows)


def _files(found: Mapping) -> str:
    names = [f"<code>{escape(Path(found[key]).name)}</code>" for key in ("effects_file", "overlay") if found.get(key)]
    again = f"<p>Again: <code>{escape(found['command'])}</code></p>" if found["command"] else ""
    return f"<h2>Files</h2><p>{', '.join(names)}, beside this one.</p>{again}"


def _list(sentences_: Sequence[str], kind: str = "") -> str:
    return f"<ul class='{kind}'>{''.join(f'<li>{escape(s)}</li>' for s in sentences_)}</ul>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    cells = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{''.join(f'<th>{escape(h)}</th>' for h in head)}</tr>{cells}</table>"


def _image(figure: Figure, words: str) -> str:
    with rc_context(plots.STYLE), BytesIO() as out:
        figure.savefig(out, format="svg", metadata={"Date": None})
        data = base64.b64encode(out.getvalue()).decode()
    return f"<img alt='{escape(words)}' src='data:image/svg+xml;base64,{data}'>"
