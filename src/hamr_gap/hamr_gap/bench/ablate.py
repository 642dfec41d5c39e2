"""The workflow without one of its steps, on cases that it has solved: what each step is worth.

Each case is solved again in a process of its own: python -m hamr_gap.bench.ablate --out out/gap_bench --without exchange
"""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import tyro

from hamr_description.errors import ConfigError, HamrError

from ..fitting import descent, roles, tune, weighed
from ..fitting.threads import use
from ..judging import analyse, weigh
from ..naming import moves, prepare, search, single_effects, sought
from . import score
from .cases import path
from .run import blind
from .solve import solve


def _judged_by_the_fitted(model, seconds_per_t: float, roles_of=roles.roles_of):
    found = roles_of(model, seconds_per_t)
    return replace(found, select=found.fit)


#: Step -> what stands in its place: (module or class, name, replacement).
STEPS: dict[str, tuple[tuple[object, str, object], ...]] = {
    "pairs": ((search, "pairs_of", lambda *_: []),),
    "exchange": ((search, "exchange", lambda *_: None),),
    "twins": ((search, "twins", lambda *_: None),),
    "fewer": ((search, "narrowed", lambda *_: []), (search, "in_its_place", lambda *_: [])),
    "elsewhere": ((search, "from_elsewhere", lambda *_: []),),
    "told_apart": ((analyse, "told_apart", lambda *of: list(of[-1])),),
    "forms": ((single_effects, "ALL_FORMS", 0),),
    "doubt": ((weighed.Weighed, "doubt", lambda *_: 1.0),),
    "led": ((search, "BETTER", 0.0),),
    "thresholds": tuple((module, "at_both", lambda *_: []) for module in (search, moves)),
    "given": ((single_effects, "ASTRAY", 0.0),),
    "timed": ((search, "LATE", float("inf")),),
    "coarser": ((descent, "FORESEEN", float("inf")),),
    "beyond": ((descent, "TRIALS", tuple((np.minimum(shares, 1.0), curved) for shares, curved in descent.TRIALS)),),
    "all_over": ((roles, "CYCLE", tuple(roles.SHARES)), (roles, "CYCLE_S", 4.0)),
    "held_out": ((tune, "roles_of", _judged_by_the_fitted),),
    "finer": ((prepare, "ENOUGH", float("inf")),),
    "staircase": ((search, "staircases", lambda *_: {}),),
    "prices": tuple((weigh, name, 0.0) for name in ("ANOTHER_EFFECT", "ONE_MORE", "ANOTHER_PLACE", "FREER", "CONTAINS")),
    "special": ((weigh, "_special", lambda *_: False),),
    "unknown": ((weigh, "UNKNOWN", 1.0), (analyse, "structural", lambda *_: False), (analyse, "ALONE", float("inf"))),
    "pieces": ((sought, "_led", lambda *_: []), (single_effects, "LOST", float("inf"))),
}


def main(out: Path, without: str, verdicts: str = "verdicts", workers: int = 2) -> None:
    """Prints both scoreboards.

    Args:
        out: folder of a benchmark. without: a step, or "all" of them, one after the other. verdicts: of the whole workflow.
    """
    if without != "all" and without not in STEPS:
        raise ConfigError(f"There is no step '{without}'; choose one of {', '.join(STEPS)}, or all.")
    numbers = sorted(int(file.stem) for file in (out / verdicts).glob("*.json"))
    numbers = [number for number in numbers if not path(out, number).is_dir()]
    boards = {"the whole": verdicts} | {f"without {step}": f"{verdicts}_without_{step}" for step in STEPS if without in (step, "all")}
    for name, folder in boards.items():
        if name != "the whole":
            files = {number: [path(out, number)] for number in numbers}
            blind(workers, out / folder, files, "ablate", "solve", name.removeprefix("without "))
        found = [score.scored(out, number, folder) for number in numbers if (out / folder / f"{number}.json").exists()]
        sys.stdout.write(json.dumps({name: dict(score.table(found))}, indent=1) + "\n")


def solve_without(step: str, answer: Path, *cases: Path) -> None:
    """As `solve.solve`, without a step."""
    with ExitStack() as stack:
        for where, name, instead in STEPS[step]:
            stack.enter_context(patch.object(where, name, instead))
        solve(answer, *cases)


if __name__ == "__main__":
    if sys.argv[1:2] == ["solve"]:
        use(1)
        solve_without(sys.argv[2], *map(Path, sys.argv[3:]))
    else:
        try:
            tyro.cli(main)
        except HamrError as error:
            sys.exit(str(error))
