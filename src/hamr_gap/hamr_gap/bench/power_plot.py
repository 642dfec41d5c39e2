"""The map of power as a picture: what each effect needs, beside the cases that say so."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from ..showing.plots import STYLE

APART = 0.26  # of a row, between lengths of record


def drawn(
    cases: Sequence[tuple[str, float, float, float, bool]], needed: Callable[[str, float], tuple[float, float, float]],
    lengths: Sequence[float],
) -> Figure:  # fmt: skip
    """Strength in floors along the axis, effects below each other, the weakest that are named first.

    A bar is the strength that is named 9 times in 10 with its 95 % interval, a dot a case: full where it was named, hollow where not.
    Bars end at the edges of the picture, beyond which nothing was tried.

    Args:
        cases: as `power.power` takes them. needed: `power.Power.needed` of them. lengths: of records, s.
    """
    strengths = [case[1] for case in cases]
    edges = min(strengths) / 1.3, max(strengths) * 1.3
    order = sorted({family for family, *_ in cases}, key=lambda family: (-needed(family, lengths[-1])[0], family))
    with rc_context(STYLE):
        figure = Figure((7.4, 0.9 + 0.33 * len(order)), layout="constrained")
        axes = figure.subplots()
        for k, seconds in enumerate(lengths):
            colour = f"C{k}"
            up = APART * (k - 0.5 * (len(lengths) - 1))
            at, low, high = np.array([np.clip(needed(family, seconds), *edges) for family in order]).T
            rows = np.arange(len(order)) + up
            axes.hlines(rows, low, high, color=colour, lw=3.5, alpha=0.3)
            axes.plot(at, rows, "|", color=colour, ms=9, mew=2, label=f"{seconds:g} s of data")
            for right in (True, False):
                own = [(x, order.index(family) + up) for family, x, s, _, ok in cases if s == seconds and ok == right]
                x, y = np.array(own).reshape(-1, 2).T
                axes.plot(x, y, "o", color=colour, mfc=colour if right else "white", ms=3.2, mew=0.9, lw=0)
        axes.set(xscale="log", xlim=edges, yticks=range(len(order)), ylim=(-0.7, len(order) - 0.3), xlabel="strength, floors of the noise")
        axes.set_yticklabels([family.replace("_", " ") for family in order])
        axes.set_xticks([x for x in (0.1, 0.2, 0.5, 1, 2, 5, 10) if edges[0] < x < edges[1]], minor=False)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
        figure.legend(loc="outside upper right", ncols=len(lengths))
    return figure
