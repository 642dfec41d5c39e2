"""Which samples serve what: fit, select, calibrate and report, never mixed, with dead time between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import BagError

from .model import Model
from .pieces import Pieces

SHARES = {"fit": 0.5, "select": 0.25, "calibrate": 0.1, "report": 0.15}
DEAD_S = 0.5  # between roles, less where a whole record is short
DEAD_SHARE = 0.03
CYCLE_S = 12.0  # in which each role has its turns
#: Of one cycle. What is fitted lies all over it, or a part that is driven in another way would be judged and never fitted.
CYCLE = ("fit", "select", "fit", "report", "fit", "select", "fit", "calibrate", "fit", "select", "fit", "report", "fit")
#: Of each piece whose start is fitted, or its judged readings would hang on a start that no fitted ones tell; of one alone twice, for what
#: nothing drives tells most before it comes to rest.
OWN_CYCLE, OWN_CYCLE_S = ("fit", "select", "fit", "calibrate", "fit", "report"), 15.0
OWN_S = 4.0  # a run of as much has turns of its own: of two, the second may show what the first does not
FEWEST, OF_EACH = 80, 4  # readings that serve at all, and in each role
TURNS = ("fit", "fit", "fit", "fit", "select", "select", "calibrate", "report")  # of whole pieces, shuffled anew each time
TINY, HALVINGS = 1e-9, 60  # to find where so many readings have been told, though some tell nothing; and how many readings roles can have
FRESH = 0.2  # of a piece: dead time enough where all starts anew


@dataclass(frozen=True, slots=True)
class Roles:
    """(n,) True where an averaged reading serves a role."""

    fit: np.ndarray
    select: np.ndarray
    calibrate: np.ndarray
    report: np.ndarray


def roles_of(model: Model, seconds_per_t: float) -> Roles:
    """Turns of the four roles, with dead time between them, and before the first unless the record begins at rest.

    In that time an unknown start, and what served another role, is forgotten.

    Raises:
        BagError: too short to be divided.
    """
    n, second = len(model.target), 1.0 / seconds_per_t / model.reading_step
    dead = _dead(n, second)
    told, roles = np.isfinite(model.target).any(1), {name: np.zeros(n, bool) for name in SHARES}
    if model.pieces is not None and len(model.pieces) >= len(TURNS) and not model.begins:
        _by_piece(model.pieces, dead, roles)
    else:
        there = _telling(model, dead)
        for start, stop, turns in _turns(model, there, told, second):
            _deal(start + np.flatnonzero(there[start:stop]), told, turns, _dead(told[start:stop].sum(), second), roles)
    useful = [int((served & told).sum()) for served in roles.values()]
    if sum(useful) < FEWEST or min(useful) < OF_EACH:
        raise BagError(f"A run has {sum(useful)} readings that serve: too few to fit on some and judge on others; record longer.")
    return Roles(**roles)


def _dead(readings: int, second: float) -> int:
    """Dead time between the roles of a run, as readings; `second` is how many one has."""
    return int(min(DEAD_S * second, DEAD_SHARE * readings))


def _turns(model: Model, there: np.ndarray, told: np.ndarray, second: float) -> list[tuple[int, int, tuple[str, ...]]]:
    """Parts of a record that have turns of their own, and these: pieces whose starts are fitted, or the record's stretches, if in each
    `OWN_S` serve, or else the whole."""
    if model.begins:
        runs, cycle, seconds = model.pieces.parts, OWN_CYCLE, OWN_CYCLE_S
    else:
        whole = any((there & told)[start:stop].sum() < OWN_S * second for start, stop in model.stretches)
        runs, cycle, seconds = [(0, len(there))] if whole else model.stretches, CYCLE, CYCLE_S
    least = 2 if model.begins and len(runs) == 1 else 1
    return [(start, stop, cycle * max(least, round(told[start:stop].sum() / second / seconds))) for start, stop in runs]


def _deal(there: np.ndarray, told: np.ndarray, turns: Sequence[str], dead: int, roles: dict[str, np.ndarray]) -> None:
    """Marks the readings `there` (m,) in the roles that have their turns, in their shares of those that are not lost (`told`)."""
    at = np.arange(len(there) + 1.0)
    before = np.append(0.0, np.cumsum(told[there])) + TINY * at  # how many are told before each

    def spans(readings: float) -> list[tuple[float, float]]:
        """Of each turn, where so many readings serve in all."""
        found, last, end = [], turns[0], 0.0
        for name in turns:
            begin = end + dead * (name != last)
            end = np.interp(np.interp(begin, at, before) + SHARES[name] * readings / turns.count(name), before, at, right=np.inf)
            found.append((begin, end))
            last = name
        return found

    few, many = 0.0, before[-1]
    for _ in range(HALVINGS):
        middle = 0.5 * (few + many)
        few, many = (middle, many) if spans(middle)[-1][1] <= at[-1] else (few, middle)
    for name, (begin, end) in zip(turns, spans(few), strict=True):
        roles[name][there[round(begin) : round(end)]] = True


def _telling(model: Model, dead: int) -> np.ndarray:
    """(n,) readings that can serve: those of the pieces, but where what runs from a guess has not forgotten it."""
    there = np.ones(len(model.target), bool)
    if model.pieces is not None:
        there[:] = False
        for start, stop in model.pieces.parts:
            there[start:stop] = True
    if not model.record.rest and not model.begins:
        for start in (0,) if model.pieces is None else model.pieces.first:
            there[start : start + dead] = False
    return there


def _by_piece(pieces: Pieces, dead: int, roles: dict[str, np.ndarray]) -> None:
    """Marks whole pieces, in turns that follow no rhythm; dead time is at the beginning of each turn, where a piece has little to say."""
    usual = float(np.median(pieces.stop - pieces.first))
    dead = int(min(dead, FRESH * usual))
    random = np.random.default_rng(0)  # or turns keep step with an excitation that repeats itself
    turns = [name for _ in range(-(-len(pieces) // len(TURNS))) for name in random.permutation(TURNS)]
    fresh, before = 0, turns[0]
    for name, (start, stop) in zip(turns, pieces.parts, strict=False):
        if name != before:
            fresh, before = start + dead, name
        roles[name][max(start, fresh) : stop] = True


def mask(model: Model, part: np.ndarray) -> np.ndarray:
    """(n, channels) True where a reading of a role exists."""
    return part[:, None] & np.isfinite(model.target)
