"""The benchmark: draw, publish the hash, solve blind in two processes, score. Interrupted runs go on where they were.

    hamr gap bench --set development --singles 40 --pairs 10 --nulls 20 --out out/gap_bench
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from hamr_description.errors import ConfigError

from . import cases, score


def bench(
    out: Path, *, set: str = "development", singles: int = 0, pairs: int = 0, triples: int = 0, nulls: int = 0, outside: int = 0,
    twins: int = 0, first: int = 0, strength: float = 5.0, seconds: float = 12.0, workers: int = 2, verdicts: str = "verdicts",
) -> dict[str, str]:  # fmt: skip
    """Runs cases of a set.

    Args:
        out: folder of cases, answers and verdicts. set: development, calibration or report; each has seeds of its own.
        singles: how many of each group. first: index of the first.
        strength: of each effect, in floors. seconds: of each record. workers: processes.
        verdicts: name of the folder of verdicts, for another version of the solver on the same cases.

    Returns:
        The scoreboard: what was counted -> its share with a 95 % interval.

    Raises:
        ConfigError: no case was asked for.
    """
    wanted = {"single": singles, "pair": pairs, "triple": triples, "null": nulls, "outside": outside, "twins": twins}
    if not any(wanted.values()):
        raise ConfigError("No case was asked for; say how many of each kind, as in --singles 4 --nulls 2.")
    jobs = [(group, first + i) for group, count in wanted.items() for i in range(count)]
    names = [cases.number(group, set, i) for group, i in jobs]
    (out / verdicts).mkdir(parents=True, exist_ok=True)
    _each(workers, "draw", [[sys.executable, "-m", "hamr_gap.bench.draw", str(out), group, set, str(i), str(strength), str(seconds)]
                            for group, i in jobs if not (out / "answers" / f"{cases.number(group, set, i)}.json").exists()])  # fmt: skip
    names = [name for name in names if (out / "answers" / f"{name}.json").exists()]
    sys.stderr.write(f"answers sha256 {cases.digest(out, names)}\n")
    todo = [name for name in names if not (out / verdicts / f"{name}.json").exists()]
    with tempfile.TemporaryDirectory() as elsewhere:
        for name in todo:
            place = Path(elsewhere) / str(name)
            place.mkdir()
            shutil.copy(out / "cases" / f"{name}.npz", place / "case.npz")
        _each(workers, "solve", [[sys.executable, "-m", "hamr_gap.bench.solve", f"{elsewhere}/{name}/case.npz",
                                  str((out / verdicts / f"{name}.json").resolve())] for name in todo])  # fmt: skip
    done = [score.scored(out, name, verdicts) for name in names if (out / verdicts / f"{name}.json").exists()]
    return dict(score.table(done))


def _each(workers: int, what: str, commands: list[list[str]]) -> None:
    """Runs commands, a few at a time, with a progress bar; one that fails is named and the rest go on."""
    environment = os.environ | {"OMP_NUM_THREADS": "1"}

    def run(command: list[str]) -> tuple[list[str], subprocess.CompletedProcess]:
        return command, subprocess.run(command, env=environment, capture_output=True, text=True)

    with ThreadPoolExecutor(workers) as pool, tqdm(total=len(commands), desc=what, unit="case", file=sys.stderr) as bar:
        for future in as_completed([pool.submit(run, command) for command in commands]):
            command, ended = future.result()
            if ended.returncode:
                last = ended.stderr.strip().splitlines()[-1:] or ["no word"]
                bar.write(f"{' '.join(command[3:])}: {last[0]}", file=sys.stderr)
            bar.update()
