"""Panels into one small picture: an SVG that is the same to the byte for the same numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

#: Colour and width of each state; dashes tell several runs of one state apart.
LOOK = {"without": ("#a8a8a8", 2.4), "with": ("#0064b4", 1.2)}
DASHES = {"": "-", "second": (0, (4, 2)), "third": (0, (1, 1.5))}
STYLE = {
    "font.size": 8, "axes.titlesize": 8, "axes.titlelocation": "left", "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#e8e8e8", "axes.axisbelow": True, "axes.formatter.use_mathtext": False, "legend.frameon": False,
    "lines.solid_joinstyle": "round", "svg.fonttype": "none", "svg.hashsalt": "hamr", "path.simplify_threshold": 0.2,
}  # fmt: skip
WIDTH, HEIGHT = 7.2, 2.45  # inches, of 72 points


@dataclass(frozen=True, slots=True)
class Curve:
    """x, y: (n,). state: of LOOK. run: of DASHES."""

    x: np.ndarray
    y: np.ndarray
    state: str
    run: str = ""


@dataclass(frozen=True, slots=True)
class Panel:
    """What one experiment shows.

    Attributes:
        title: what was done. x, y: axis labels. curves. shows: how to read it, a sentence. log: the logarithmic ones of x and y.
    """

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    shows: str
    log: str = ""


def pair(x: np.ndarray, y: np.ndarray, run: str = "") -> tuple[Curve, ...]:
    """Curves without and with of y (2, n) over x (n,) or (2, n)."""
    return tuple(Curve(np.broadcast_to(x, y.shape)[i], y[i], state, run) for i, state in enumerate(LOOK))


def svg(panels: Sequence[Panel]) -> str:
    """One picture, panels side by side, about 700 pixels wide."""
    with rc_context(STYLE):
        figure = Figure((WIDTH, HEIGHT), layout="constrained")
        for axis, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            _draw(axis, panel)
        lines = [Line2D([], [], color=colour, lw=width) for colour, width in LOOK.values()]
        figure.legend(lines, LOOK, loc="outside upper right", ncols=len(LOOK), borderpad=0.0)
        text = StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _small(text.getvalue())


def _draw(axis, panel: Panel) -> None:
    for curve in sorted(panel.curves, key=lambda c: list(LOOK).index(c.state)):
        colour, width = LOOK[curve.state]
        axis.plot(curve.x, curve.y, color=colour, lw=width, ls=DASHES[curve.run])
    axis.set_title(panel.title)
    axis.set_xlabel(panel.x)
    axis.set_ylabel(panel.y)
    axis.tick_params(length=0)
    for name in "xy":
        if name in panel.log:
            getattr(axis, f"set_{name}scale")("log")
            ticks = getattr(axis, f"{name}axis")
            ticks.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if name == "x" else (1.0, 3.0)))
            ticks.set_major_formatter("{x:g}")
        else:
            axis.locator_params(axis=name, nbins=5)
    axis.minorticks_off()


def _small(text: str) -> str:
    """The same picture in fewer letters: coordinates to a tenth of a point, one font for all text, no indents."""
    text = re.sub(r' d="[^"]*"', lambda data: re.sub(r"\s+L?\s*", " ", _rounded(data)), text)  # after a move, pairs are lines
    text = re.sub(r' (x|y|transform)="[^"]*"', _rounded, text)
    text = re.sub(r"font-size: 8px; font-family: [^;\"]*(; )?", "", text)
    text = text.replace("*{", "text{font: 8px 'DejaVu Sans', Verdana, sans-serif} *{", 1)
    text = re.sub(r' transform="rotate\(-0 [^"]*"', "", text)
    return re.sub(r"\n\s*", "\n", text)


def _rounded(attribute: re.Match) -> str:
    return re.sub(r"-?\d+\.\d+", lambda x: f"{float(x[0]):.1f}".removesuffix(".0"), attribute[0])
