"""A baseline on cases of a benchmark that were drawn before; cases that have a verdict are left as they are.

python -m hamr_gap.bench.baselines --out out/gap_bench --cases 100000 130000 --method stepwise --verdicts stepwise
python -m hamr_gap.bench.baselines.compare --out out/gap_bench --cases 100000 130000 --workflow verdicts --baselines stepwise
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path as File
from typing import Literal

from tqdm import tqdm

from hamr_description.errors import ConfigError, HamrError

from ...legs import machine_of
from ...naming.prepare import Prepared, prepare
from ..cases import LEG, load
from .everything import everything
from .residual_network import network
from .result import Path, result
from .sindy import sindy
from .stepwise import stepwise

METHODS: dict[str, Callable[[Prepared], Path]] = {"stepwise": stepwise, "sindy": sindy, "everything": everything, "network": network}


def baselines(out: File, *, cases: list[int], method: Literal["stepwise", "sindy", "everything", "network"], verdicts: str = "") -> None:
    """Runs a baseline on cases and writes a verdict file for each.

    Args:
        out: folder that `hamr gap bench` made. cases: their names.
        verdicts: name of the folder of verdicts; the method's if not given.
    """
    folder = out / (verdicts or method)
    folder.mkdir(parents=True, exist_ok=True)
    for name in tqdm([n for n in cases if not (folder / f"{n}.json").exists()], desc=method, unit="case", file=sys.stderr):
        part = folder / f"{name}.part"
        part.write_text(json.dumps(solved(out / "cases" / f"{name}.npz", METHODS[method])))
        part.rename(folder / f"{name}.json")


def solved(case: File, method: Callable[[Prepared], Path]) -> dict:
    """The verdict file of a case.

    Raises:
        ConfigError: there is no such case, or the method needs a library that is not installed.
    """
    if not case.exists():
        raise ConfigError(f"There is no case at {case}: draw it with `hamr gap bench` first.")
    began = time.process_time()
    try:
        prepared = prepare(machine_of("simple", LEG), load(case))
        found = result(prepared, method(prepared))
    except ConfigError:
        raise
    except HamrError as error:
        found = {"verdict": "refused", "why": str(error), "weights": []}
    return found | {"seconds": time.process_time() - began}
