"""The search for what is missing on the ground: all in the linear picture, the best fitted alone and in pairs, and judged elsewhere."""

from __future__ import annotations

from collections.abc import Callable

from . import again, looks
from .prepare import prepare
from .state import Search
from .walk import Walk


def search(backend: str, walk: Walk, report: Callable[[str], None] = lambda _: None) -> Search:
    """What could be missing from a backend on the ground.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    state = Search(prepare(backend, walk, report))
    if not state.prepared.gap:
        return state
    report("screen")
    seen = looks.screen(state)
    singles = seen.singles()
    report("singles")
    state.tried += map(state.judged, [*looks.alone(state, seen, singles), *looks.outside(state)])
    again.polish(state)
    if state.gains:
        report("sets of 2")
        state.tried += map(state.judged, looks.pairs(state, seen, singles))
        again.settle(state)
    if state.prepared.coarse:
        report("finer steps")
        again.refine(state)
    if state.gains:
        again.shake(state)
    return state
