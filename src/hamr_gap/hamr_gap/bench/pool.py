"""One table from several listings of the benchmark: python -m hamr_gap.bench.pool docs/gap_bench/*th.csv

Each set was drawn and solved once with the code that was there then, so the pool says how the workflow did on cases that it had not seen.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import tyro

from hamr_description.errors import HamrError

from .listing import read
from .rates import rate

KNOWN = ("single", "pair", "triple")


def pooled(lines: Iterable[dict[str, str]]) -> list[tuple[str, str]]:
    """Rows of the scoreboard that listings can tell, with the families that were hidden as clusters."""
    lines = list(lines)

    def share(groups: tuple[str, ...], what, among=lambda line: True) -> str:
        chosen = [line for line in lines if line["group"] in groups and among(line)]
        return rate([bool(what(line)) for line in chosen], [families(line["hidden"]) or line["case"] for line in chosen])

    def right(line):
        return line["right"] == "1"

    def said(*verdicts):
        return lambda line: line["verdict"] in verdicts

    rows = [(f"{group}s: exact", share((group,), right)) for group in KNOWN]
    rows += [
        ("nulls: false alarms", share(("null",), lambda line: not right(line))),
        ("outside the library: called unknown", share(("outside",), said("unknown"))),
        ("outside the library: confident and wrong", share(("outside",), said("named"))),
        ("known ones called unknown", share(KNOWN, said("unknown"))),
        ("known ones: confident and wrong", share(KNOWN, lambda line: said("named")(line) and not right(line))),
        ("known ones missed (no gap, or parameters only)", share(KNOWN, said("no_significant_gap", "parameters_only"))),
        ("90 % sets hold the answer", share(KNOWN, lambda line: line["in_set"] == "1", said("named", "ambiguous", "unknown"))),
    ]
    seconds = [float(line["seconds"]) for line in lines]
    rows.append(("processor seconds: median, 90th percentile", f"{np.median(seconds):.0f}, {np.percentile(seconds, 90):.0f}"))
    return [row for row in rows if row[1] != "-"]


def families(hidden: str) -> str:
    """What was hidden, without places: "backlash + drive_lag"; nothing for a null."""
    return " + ".join(re.findall(r"(\w+) \(", hidden))


def main(listings: tyro.conf.Positional[tuple[Path, ...]], but: tuple[str, ...] = ()) -> None:
    """Prints the table.

    Args:
        listings: files that `hamr gap bench` wrote. but: laws outside, or sets of names, whose cases are left out.
    """
    rows = pooled(line for path in listings for line in read(path) if families(line["hidden"]) not in but)
    sys.stdout.write("| | |\n|---|---|\n" + "".join(f"| {what} | {value} |\n" for what, value in rows))


if __name__ == "__main__":
    try:
        tyro.cli(main)
    except HamrError as error:
        sys.exit(str(error))
