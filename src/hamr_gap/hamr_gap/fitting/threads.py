"""Runs and fits on all cores: kernels let other threads go on. Results do not depend on how many there are."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item, Result = TypeVar("Item"), TypeVar("Result")
_count = 1 if multiprocessing.parent_process() else os.cpu_count() or 1  # legs beside each other have a core each


def use(count: int) -> None:
    """Sets how many threads work at once."""
    global _count
    _count = count


def at_once(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Results of some work on each item, in their order; the first error is raised."""
    items = list(items)
    if min(_count, len(items)) < 2:
        return [work(item) for item in items]
    with ThreadPoolExecutor(_count) as pool:
        return list(pool.map(work, items))
