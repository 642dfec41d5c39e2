"""Which readings serve what: apart from each other, none in two roles, and every part of a run in most of them."""

from __future__ import annotations

from itertools import combinations, pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_description.errors import BagError
from hamr_gap.fitting.roles import DEAD_S, DEAD_SHARE, SHARES, roles_of


def roles(readings: int, *more: int, rest: bool = False, lost: slice = slice(0)) -> dict[str, np.ndarray]:
    """Of a run of so many readings, or of several, each from rest or none; some may be lost."""
    edges = np.cumsum([0, readings, *more])
    target = np.zeros((edges[-1], 2))
    target[lost] = np.nan
    model = SimpleNamespace(
        target=target, reading_step=1.0, pieces=None, record=SimpleNamespace(rest=rest),
        stretches=list(pairwise(edges.tolist())), begins=False,
    )  # fmt: skip
    return vars_of(roles_of(model, 1e-3))


def vars_of(found) -> dict[str, np.ndarray]:
    return {name: getattr(found, name) for name in SHARES}


@given(st.integers(400, 70_000), st.booleans())
def test_roles_keep_their_distance(readings, rest):
    found = roles(readings, rest=rest)
    apart = int(min(DEAD_S * 1e3, DEAD_SHARE * readings))
    role = np.zeros(readings, int)
    for k, rows in enumerate(found.values()):
        role[rows] = k + 1
    assert all(not (a & b).any() for a, b in combinations(found.values(), 2))
    served = np.flatnonzero(role)
    assert served[0] == 0 if rest else served[0] >= apart
    assert served[-1] >= readings - 2
    for a, b in zip(served[:-1], served[1:], strict=True):
        assert role[a] == role[b] or b - a > apart - 2
    shares = np.array([rows.sum() for rows in found.values()]) / (role > 0).sum()
    assert shares == pytest.approx(list(SHARES.values()), abs=0.03)


@given(st.integers(2000, 50_000), st.floats(0.0, 0.8), st.floats(0.05, 0.6))
def test_lost_readings_take_from_all_roles_alike(readings, begin, share):
    """A gap, or what a hit leaves out, may lie where one role would have had all of its turns."""
    lost = slice(int(begin * readings), int((begin + share * (1.0 - begin)) * readings))
    found = roles(readings, lost=lost)
    told = np.ones(readings, bool)
    told[lost] = False
    shares = np.array([(rows & told).sum() for rows in found.values()], float)
    assert shares / shares.sum() == pytest.approx(list(SHARES.values()), abs=0.03)
    role = np.sum([(k + 1) * rows for k, rows in enumerate(found.values())], 0)
    served = np.flatnonzero(role)
    apart = int(min(DEAD_S * 1e3, DEAD_SHARE * told.sum()))
    changes = role[served[:-1]] != role[served[1:]]
    assert (np.diff(served)[changes] > apart - 2).all()
    assert shares.sum() >= told.sum() - (apart + 1) * changes.sum() - DEAD_SHARE * readings - 2  # the start is forgotten first


@pytest.mark.parametrize("seconds", [6, 12, 20, 60])
def test_what_is_fitted_and_what_selects_lie_all_over_a_run(seconds):
    """A run that is driven in another way in its last fifth, as mixes are, is fitted there too, and judged there."""
    found = roles(seconds * 1000)
    fifths = {name: [part.mean() for part in np.array_split(rows, 5)] for name, rows in found.items()}
    assert min(fifths["fit"]) > 0.08
    assert sum(x > 0.0 for x in fifths["select"]) >= 3
    gaps = np.diff(np.flatnonzero(found["fit"])).max()
    assert gaps < 0.16 * min(seconds, 12) * 1000


def test_each_run_of_some_seconds_serves_every_role():
    """A second run may show what the first does not: it is fitted, judged, confirmed and reported on as well."""
    found = roles(12_000, 4000, 30_000, rest=True)
    for part in (slice(0, 12_000), slice(12_000, 16_000), slice(16_000, None)):
        shares = np.array([rows[part].sum() for rows in found.values()]) / sum(rows[part].sum() for rows in found.values())
        assert shares == pytest.approx(list(SHARES.values()), abs=0.03)


def test_runs_too_short_for_all_turns_are_dealt_as_one():
    one, several = roles(12_000, rest=True), roles(11_000, 1000, rest=True)
    assert all((one[name] == several[name]).all() for name in SHARES)


@pytest.mark.parametrize("rest", [True, False])
def test_roles_lie_where_runs_start_from_what_was_measured(rest):
    """Of three stretches two can be run: each role has its share of these, less what an unknown start needs to be forgotten."""
    pieces = Runs(first=np.array([1000, 6000]), stop=np.array([3000, 8000]))
    model = SimpleNamespace(
        target=np.zeros((9000, 1)), reading_step=1.0, pieces=pieces, record=SimpleNamespace(rest=rest), stretches=[(0, 9000)], begins=False,
    )  # fmt: skip
    found = vars_of(roles_of(model, 1e-3))
    served = np.flatnonzero(np.any(list(found.values()), axis=0))
    apart = int(DEAD_SHARE * 9000)
    begin = 0 if rest else apart
    assert all(((a + begin <= served) & (served < b)).any() for a, b in zip(pieces.first, pieces.stop, strict=True))
    assert not [k for k in served if not (1000 + begin <= k < 3000 or 6000 + begin <= k < 8000)]
    shares = np.array([rows.sum() for rows in found.values()]) / len(served)
    assert shares == pytest.approx(list(SHARES.values()), abs=0.03)


class Runs(SimpleNamespace):
    def __len__(self) -> int:
        return len(self.first)

    @property
    def parts(self) -> list[tuple[int, int]]:
        return list(zip(self.first.tolist(), self.stop.tolist(), strict=True))


def test_too_short_a_record_says_so():
    with pytest.raises(BagError, match="record longer"):
        roles(60)
