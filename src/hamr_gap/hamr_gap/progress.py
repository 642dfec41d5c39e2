"""Legs analysed in processes beside each other, with one bar on standard error."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from threading import Thread
from typing import TypeVar

from tqdm import tqdm

#: What `analyse` reports, in order; the later ones are left out where nothing is to be found.
STAGES = ("re-tune", "screen", "singles", "sets of 2", "sets of 3", "intervals")
PROCESSES = 2

Result = TypeVar("Result")
Job = Callable[[Callable[[str], None]], Result]
_told = None


def side_by_side(jobs: Mapping[str, Job]) -> dict[str, Result]:
    """Runs jobs, each of which is told to whom to report its stage; in this process if there is only one or one core.

    Jobs and results must be picklable.
    """
    count = min(PROCESSES, os.cpu_count() or 1, len(jobs))
    with _bar(list(jobs)) as tell:
        if count < 2:
            return {name: _whole(name, job, tell) for name, job in jobs.items()}
        context = multiprocessing.get_context("spawn")
        queue = context.SimpleQueue()
        listener = Thread(target=lambda: [tell(*message) for message in iter(queue.get, None)], daemon=True)
        listener.start()
        pool = ProcessPoolExecutor(count, context, _hear, (queue,))
        try:
            futures = {name: pool.submit(_child, name, job) for name, job in jobs.items()}
            return {name: future.result() for name, future in futures.items()}
        finally:
            pool.shutdown(cancel_futures=True)
            queue.put(None)
            listener.join()


def _whole(name: str, job: Job, tell: Callable[[str, str], None]) -> Result:
    result = job(lambda stage: tell(name, stage))
    tell(name, "")
    return result


def _hear(queue) -> None:
    global _told
    _told = queue


def _child(name: str, job: Job) -> Result:
    return _whole(name, job, lambda *message: _told.put(message))


@contextmanager
def _bar(names: list[str]):
    at = dict.fromkeys(names, 0)
    with tqdm(total=len(names) * len(STAGES), file=sys.stderr, bar_format="{desc}{percentage:3.0f} % |{bar:30}| {elapsed}{postfix}") as bar:

        def tell(name: str, stage: str) -> None:
            at[name] = STAGES.index(stage) if stage in STAGES else len(STAGES) if not stage else at[name]
            bar.n = sum(at.values())
            bar.set_postfix_str(f"{name}: {stage or 'done'}")

        yield tell
