"""How many seconds of data does a residual need? `python -m hamr_bringup.seconds_of_data BAG` trains both methods on heads of one bag.

The bag is what the shipped model is made of, `hamr collect --backend full --out BAG --direct`. The tables of docs/residual.md go to
standard output, the picture and the models into a folder.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import tyro
from tyro.conf import Positional

from hamr_bags.excitation import excitation
from hamr_bags.reader import load
from hamr_sim_residual.study import SECONDS, curve, curve_figure, held_out

SAME_BAND = "noise, other seed"
HORIZONS_MS = (8.0, 300.0)


def table(rows: list[dict]) -> str:
    """Gains (position / velocity) on noise of another seed, and the least gain on all other runs, as a Markdown table."""
    gained = [f"{where} {h:g} ms" for where in ("after", "other runs' least, after") for h in HORIZONS_MS]
    heads = ("method", "seconds", *gained, "finite")
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for method, seconds in dict.fromkeys((row["method"], row["seconds"]) for row in rows):
        mine = [row for row in rows if (row["method"], row["seconds"]) == (method, seconds)]
        cells = [_gains(mine, h, same_band) for same_band in (True, False) for h in HORIZONS_MS]
        finite = "yes" if all(row["finite"] for row in mine) else "NO"
        lines.append(f"| {method} | {seconds:g} | {' | '.join(cells)} | {finite} |")
    return "\n".join([*lines, ""])


def _gains(rows: Iterable[dict], horizon_ms: float, same_band: bool) -> str:
    rows = [row for row in rows if row["horizon_ms"] == horizon_ms and (row["run"] == SAME_BAND) == same_band]
    return " / ".join(_short(min(row["gain"] for row in rows if row["quantity"] == quantity)) for quantity in ("position", "velocity"))


def _short(gain: float) -> str:
    return f"{float(f'{gain:.2g}'):,.6g}".replace(",", " ")


def main(
    bag: Positional[Annotated[Path, tyro.conf.arg(metavar="BAG")]], out: Path = Path("out/seconds"),
    methods: tuple[str, ...] = ("adjoint", "paper"), seconds: tuple[float, ...] = SECONDS,
) -> None:  # fmt: skip
    """Trains every method on the first seconds of a bag and measures on runs that no training saw; about twenty minutes.

    Args:
        bag: of HAMR-full, suspended, at least as long as the longest of `seconds`.
        out: folder for the models and the picture.
        methods: of adjoint, paper, paper-euler.
        seconds: of data, each a training.
    """
    runs = held_out(lambda *kind, **parameters: excitation(*kind, **parameters).voltages)
    rows = curve(load(bag), runs, out, methods=methods, seconds=seconds, horizons=HORIZONS_MS)
    curve_figure(rows, out / "seconds_of_data.png")
    sys.stdout.write(table(rows))


if __name__ == "__main__":
    tyro.cli(main)
