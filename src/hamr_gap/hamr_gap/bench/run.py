"""The benchmark: draw, publish the hash, solve blind in two processes, score. Interrupted runs go on where they were.

Each case is drawn, solved and looked at in processes of their own, which know nothing of each other.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from hamr_description.errors import ConfigError

from . import cases, decidable, listing, other, score, second, told


def bench(
    out: Path, *, set: str = "development", singles: int = 0, pairs: int = 0, triples: int = 0, nulls: int = 0, outside: int = 0,
    twins: int = 0, ground: int = 0, ground_nulls: int = 0, first: int = 0, strength: float = 5.0, seconds: float = 12.0,
    again: bool = False, stable: bool = False, ideals: bool = False, workers: int = 2, verdicts: str = "verdicts",
) -> dict[str, str]:  # fmt: skip
    """Runs cases of a set.

    Args:
        out: folder of cases, answers and verdicts. set: development, calibration or report; each has seeds of its own.
        singles: how many of each group. first: index of the first.
        strength: of each effect, in floors. seconds: of each record. again: whether experiments that verdicts ask for are made, on legs.
        stable: whether cases are solved with other noise, and from half of the data, too.
        ideals: whether noise-free data are asked what could have been told. workers: processes.
        verdicts: name of the folder of verdicts, for another version of the solver on the same cases.

    Returns:
        The scoreboard: what was counted -> its share with a 95 % interval. `VERDICTS.csv` in `out` has a line for each case.

    Raises:
        ConfigError: no case was asked for.
    """
    wanted = {"single": singles, "pair": pairs, "triple": triples, "null": nulls, "outside": outside, "twins": twins,
              "ground": ground, "ground_null": ground_nulls}  # fmt: skip
    if not any(wanted.values()):
        raise ConfigError("No case was asked for; say how many of each kind, as in --singles 4 --nulls 2.")
    jobs = {cases.number(group, set, i): (group, i) for group, count in wanted.items() for i in range(first, first + count)}
    todo = [job for name, job in jobs.items() if not _answer(out, name).exists()]
    _each(workers, "draw", [[str(out), group, set, str(i), str(strength), str(seconds)] for group, i in todo])
    names = [name for name in jobs if _answer(out, name).exists()]
    sys.stderr.write(f"answers sha256 {cases.digest(out, names)}\n")
    blind(workers, out / verdicts, {name: [cases.path(out, name)] for name in names})
    legs = [name for name in names if not cases.path(out, name).is_dir()]
    if again:
        asked = [name for name in legs if (out / verdicts / f"{name}.npz").exists()]
        runs = {name: second.folder_of(out, verdicts) / f"{name}.npz" for name in asked}
        _each(workers, "second", [[str(out), verdicts, str(name)] for name, path in runs.items() if not path.exists()])
        both = {name: [cases.path(out, name), path] for name, path in runs.items() if path.exists()}
        blind(workers, score.kept_in(out, verdicts, "second"), both)
    if stable:
        _each(workers, "other", [[str(out), str(name)] for name in legs if not other.file_of(out, other.WAYS[-1], name).exists()])
        for way in other.WAYS:
            runs = {name: [other.file_of(out, way, name)] for name in legs if other.file_of(out, way, name).exists()}
            blind(workers, score.kept_in(out, verdicts, way), runs)
    if ideals:
        _each(workers, "ideal", [[str(out), str(name)] for name in legs if not (out / "ideals" / f"{name}.json").exists()])
    done = [score.scored(out, name, verdicts) for name in names if (out / verdicts / f"{name}.json").exists()]
    if ideals:
        unsure = [c.name for c in told.unsure(done) if not (score.kept_in(out, verdicts, decidable.WAY) / f"{c.name}.json").exists()]
        _each(workers, "decidable", [[str(out), verdicts, str(name)] for name in unsure])
    listing.write(out / f"{verdicts}.csv", done)
    lost = " ".join(str(name) for name in names if name not in {c.name for c in done})
    return dict([*score.table(done), *told.rows(out, done, verdicts), *([("no verdict, not counted above", lost)] if lost else [])])


def _answer(out: Path, name: int) -> Path:
    return out / "answers" / f"{name}.json"


def blind(workers: int, verdicts: Path, files: Mapping[int, Sequence[Path]], what: str = "solve", *more: str) -> None:
    """Solves cases that have no verdict, each with nothing but its own files beside it.

    Args:
        verdicts: folder to write to. files: of each case. what: module that solves, and its first arguments.
    """
    verdicts.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as elsewhere:
        commands = []
        for name, own in files.items():
            if (answer := verdicts.resolve() / f"{name}.json").exists():
                continue
            place = Path(elsewhere, str(name))
            place.mkdir()
            copies = [_copied(path, place / f"case{i}{path.suffix}") for i, path in enumerate(own)]
            commands.append([*more, str(answer), *map(str, copies)])
        _each(workers, what, commands)


def _copied(path: Path, to: Path) -> Path:
    """A file, or the folder of a bag."""
    return (shutil.copytree if path.is_dir() else shutil.copy)(path, to)


def _each(workers: int, what: str, jobs: list[list[str]]) -> None:
    """Runs modules of this package with arguments, a few at a time, with a progress bar; one that fails is named and the rest go on."""
    environment = os.environ | {"OMP_NUM_THREADS": "1"}

    def run(job: list[str]) -> tuple[list[str], subprocess.CompletedProcess]:
        command = [sys.executable, "-m", f"{__package__}.{what}", *job]
        return job, subprocess.run(command, env=environment, capture_output=True, text=True)

    with ThreadPoolExecutor(workers) as pool, tqdm(total=len(jobs), desc=what, unit="case", file=sys.stderr) as bar:
        for future in as_completed([pool.submit(run, job) for job in jobs]):
            job, ended = future.result()
            if ended.returncode:
                last = ended.stderr.strip().splitlines()[-1:] or ["no word"]
                bar.write(f"{what} {' '.join(job)}: {last[0]}", file=sys.stderr)
            bar.update()
