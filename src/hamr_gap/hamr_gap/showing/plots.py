"""The pictures of a report: each a function from plain arrays to a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.signal import welch

from hamr_dynamics.effects.force_table import NODES

Arrays = Mapping[str, np.ndarray]
#: Colour and words of each state.
LOOK = {
    "target": ("#222222", "measured"), "raw": ("#b9b9b9", "as given"), "retuned": ("#e07b00", "re-tuned"),
    "after": ("#0064b4", "with the effect"), "removed": ("#8a4fbf", "effect taken out again"),
}  # fmt: skip
STYLE = {
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 9, "axes.titlelocation": "left",
    "legend.frameon": False, "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "svg.hashsalt": "hamr",
}  # fmt: skip
#: SI unit -> factor and unit in pictures.
SHOWN = {"rad": (180.0 / np.pi, "degrees"), "m": (1e6, "um")}
CELLS = (8, 24)  # of a map, along each axis, from few readings to many
LONG = 60  # letters, from which names of several effects stand below each other
FEWEST = 3  # readings in a cell that is drawn


def _figure(width: float, height: float, rows: int = 1, columns: int = 1, **options):
    with rc_context(STYLE):
        figure = Figure((width, height), layout="constrained")
        return figure, figure.subplots(rows, columns, squeeze=False, **options)


def _shown(unit: str) -> tuple[float, str]:
    return SHOWN.get(unit, (1.0, unit))


def traces(arrays: Arrays, channels: Mapping[str, str], states: Sequence[str]) -> Figure:
    """Readings over a short window, measured and simulated; and what is left of the gap below. Args: channels, name -> unit."""
    part = slice(*arrays["window"])
    with rc_context(STYLE):
        figure, axes = _figure(4.6 * len(channels), 4.2, 2, len(channels), sharex=True, height_ratios=(2, 1))
        for c, (channel, unit) in enumerate(channels.items()):
            factor, said = _shown(unit)
            above, below = axes[:, c]
            for state in ("target", *states):
                y = factor * arrays[state][part, c]
                colour, words = LOOK[state]
                above.plot(
                    arrays["time"][part],
                    y,
                    color=colour,
                    lw=2.6 if state == "target" else 1.1,
                    alpha=0.35 if state == "target" else 1,
                    label=words,
                )
                if state not in ("target", "raw"):
                    below.plot(arrays["time"][part], factor * arrays["target"][part, c] - y, color=colour, lw=0.9)
            noise = 2.0 * factor * arrays["noise"][c]
            below.axhspan(-noise, noise, color="#cccccc", alpha=0.5, lw=0)
            above.set_title(channel)
            above.set_ylabel(said)
            below.set_ylabel(f"difference, {said}")
            below.set_xlabel("s")
        axes[1, 0].annotate("grey: 2 standard deviations of the noise", (0.01, 0.03), xycoords="axes fraction", fontsize=7, color="#666666")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(states) + 1)
    return figure


def spectra(arrays: Arrays, channels: Mapping[str, str], states: Sequence[str]) -> Figure:
    """Amplitude density of the differences against the noise."""
    part, rate = _longest(arrays["used"]), 1.0 / float(np.median(np.diff(arrays["time"])))
    with rc_context(STYLE):
        figure, axes = _figure(4.6 * len(channels), 2.7, 1, len(channels))
        for c, (channel, unit) in enumerate(channels.items()):
            factor, said = _shown(unit)
            axis, best = axes[0, c], np.inf
            for state in states:
                left = factor * np.nan_to_num((arrays["target"] - arrays[state])[part, c])
                f, power = welch(left, rate, nperseg=min(512, len(left)))
                density = np.sqrt(power)
                axis.loglog(f[1:], density[1:], color=LOOK[state][0], lw=1.2, label=LOOK[state][1])
                best = min(best, density[1:].min())
            level = factor * arrays["noise"][c] * np.sqrt(2.0 / rate)
            axis.axhline(level, color="#666666", lw=1, ls="--", label="sensor noise")
            axis.set_ylim(bottom=0.3 * min(level, max(best, 0.1 * level)))
            axis.set_title(channel)
            axis.set_xlabel("Hz")
            axis.set_ylabel(f"difference, {said}/sqrt(Hz)")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(states) + 1)
    return figure


def _longest(used: np.ndarray) -> slice:
    """The longest stretch of readings that count."""
    edges = np.flatnonzero(np.diff(np.r_[0, used.astype(int), 0]))
    starts, stops = edges[::2], edges[1::2]
    k = int(np.argmax(stops - starts))
    return slice(starts[k], stops[k])


def maps(arrays: Arrays, channels: Mapping[str, str], states: Sequence[str]) -> Figure:
    """Mean difference over readings and their rates, of re-tuned model and of the one with the effect, one colour scale for both."""
    used = np.flatnonzero(arrays["used"])
    step = float(np.median(np.diff(arrays["time"])))
    cells = int(np.clip(np.sqrt(len(used) / 10), *CELLS))
    with rc_context(STYLE):
        figure, axes = _figure(2.7 * len(channels) * len(states), 2.6, 1, len(channels) * len(states))
        for c, (channel, unit) in enumerate(channels.items()):
            factor, said = _shown(unit)
            q = factor * arrays["after"][:, c]
            v = np.gradient(q, step)
            edges = [np.linspace(*np.percentile(x[used], (0.5, 99.5)), cells + 1) for x in (q, v)]
            found = {}
            for state in states:
                left = factor * (arrays["target"][:, c] - arrays[state][:, c])[used]
                known = np.isfinite(left)
                count = np.histogram2d(q[used][known], v[used][known], edges)[0]
                total = np.histogram2d(q[used][known], v[used][known], edges, weights=left[known])[0]
                found[state] = np.where(count >= FEWEST, total / np.maximum(count, 1), np.nan)
            top = max(float(np.nanpercentile(np.abs(x), 98)) if np.isfinite(x).any() else 1.0 for x in found.values()) or 1.0
            for k, state in enumerate(states):
                axis = axes[0, c * len(states) + k]
                axis.grid(False)
                image = axis.imshow(
                    found[state].T,
                    origin="lower",
                    aspect="auto",
                    extent=(*edges[0][[0, -1]], *edges[1][[0, -1]]),
                    cmap="RdBu_r",
                    vmin=-top,
                    vmax=top,
                )
                axis.set_title(f"{channel}, {LOOK[state][1]}", fontsize=8)
                axis.set_xlabel(said)
                if k == 0:
                    axis.set_ylabel(f"{said}/s")
            figure.colorbar(image, ax=list(axes[0, c * len(states) : (c + 1) * len(states)]), label=f"mean difference, {said}", shrink=0.9)
    return figure


def left_by_names(tried: Sequence[Mapping], right: Sequence[str]) -> Figure:
    """What each name left of the gap on readings that were not fitted. Args: right, names in the credible set."""
    rows = list(tried)[:10][::-1]
    with rc_context(STYLE):
        names = [row["effects"] if len(row["effects"]) < LONG else row["effects"].replace(" + ", " +\n") for row in rows]
        lines = max((name.count("\n") for name in names), default=0) + 1
        figure, axes = _figure(9.2, 0.5 + (0.12 + 0.15 * lines) * max(len(rows), 2))
        axis = axes[0, 0]
        left = [max(100.0 * row["left"], 0.01) for row in rows]
        colours = [LOOK["after"][0] if row["effects"] in right else "#bdbdbd" for row in rows]
        axis.barh(names, left, color=colours, height=0.7)
        for i, x in enumerate(left):
            axis.annotate(f" {x:.3g} %", (x, i), va="center", fontsize=8)
        axis.set_xscale("log")
        axis.set_xlim(min(0.1, 0.5 * min(left, default=1.0)), 300)
        axis.grid(axis="y", visible=False)
        axis.set_xlabel("gap left, % of the re-tuned one (mean square, less noise)")
    return figure


def gap_bars(over: Mapping[str, Mapping[str, float]], states: Sequence[str]) -> Figure:
    """Rms of the difference in units of the noise, of each machine in each state."""
    with rc_context(STYLE):
        figure, axes = _figure(9.2, 2.4)
        axis, width = axes[0, 0], 0.8 / len(states)
        for k, state in enumerate(states):
            x = np.arange(len(over)) + (k - 0.5 * (len(states) - 1)) * width
            bars = axis.bar(x, [values[state] for values in over.values()], 0.92 * width, color=LOOK[state][0], label=LOOK[state][1])
            axis.bar_label(bars, fmt="%.3g", fontsize=8)
        axis.axhline(1.0, color="#222222", lw=1, ls="--", label="sensor noise")
        axis.set_xticks(range(len(over)), list(over))
        axis.set_yscale("log")
        axis.set_ylim(0.5, 3.0 * max(max(values[s] for s in states) for values in over.values()))
        axis.grid(axis="x", visible=False)
        axis.set_ylabel("rms difference / noise")
        figure.legend(*axis.get_legend_handles_labels(), loc="outside upper center", ncols=len(states) + 1, fontsize=8)
    return figure


def table_effect(effect: Mapping) -> Figure:
    """The force, or the drive, found where no name fits."""
    at = next(iter(next(iter(effect["parameters"].values()))))
    values = {name: places[at] for name, places in effect["parameters"].items()}
    with rc_context(STYLE):
        figure, axes = _figure(4.6, 3.0)
        axis = axes[0, 0]
        axis.set_title(f"found at {', '.join(effect['joints'])}")
        if effect["form"] == "drive_curve":
            nodes = (np.arange(7) - 3) * values["unit"]["value"]
            curve, low, high = (np.array([values[f"u{i}"][key] for i in range(7)]) for key in ("value", "low", "high"))
            axis.fill_between(nodes, low, high, color=LOOK["after"][0], alpha=0.2, lw=0)
            axis.plot(nodes, curve, "o-", color=LOOK["after"][0])
            axis.set_xlabel(f"drive, {values['unit']['unit']}")
            axis.set_ylabel(f"added to it, {values['u0']['unit']}")
        else:
            nodes = np.arange(NODES) - 0.5 * (NODES - 1)
            force = np.array([[values[f"f{i}{j}"]["value"] for j in range(NODES)] for i in range(NODES)])
            top = float(np.abs(force).max()) or 1.0
            ends = [(nodes[0] - 0.5) * values[name]["value"] for name in ("angle", "rate")]
            axis.grid(False)
            image = axis.imshow(
                force.T, origin="lower", aspect="auto", cmap="RdBu_r", vmin=-top, vmax=top, extent=(ends[0], -ends[0], ends[1], -ends[1])
            )
            figure.colorbar(image, label=f"force, {values['f00']['unit']}")
            axis.set_xlabel(f"{values['angle']['unit']}")
            axis.set_ylabel(f"{values['rate']['unit']}")
    return figure
