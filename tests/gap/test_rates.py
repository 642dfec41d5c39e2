"""Shares with intervals, against scipy's and against what clusters of equal cases must do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from hamr_description.errors import ConfigError
from hamr_gap.bench.listing import DATA, read
from hamr_gap.bench.pool import main, pooled
from hamr_gap.bench.rates import interval, rate

DOCS = Path(__file__).resolve().parents[2] / "docs"


@given(st.lists(st.booleans(), min_size=2, max_size=60))
def test_of_cases_with_nothing_in_common_it_is_clopper_and_pearsons(hits):
    exact = binomtest(sum(hits), len(hits)).proportion_ci(0.95, "exact")
    assert interval(np.array(hits), range(len(hits))) == pytest.approx((exact.low, exact.high), abs=1e-9)


def test_it_is_said_as_a_share():
    assert rate([True] * 10) == "100 % (69..100, n = 10)"  # Clopper-Pearson: 1 - 0.025^(1/10)
    assert rate([]) == "-"


@pytest.mark.parametrize("copies", [2, 5])
def test_cases_said_again_say_nothing_new(copies):
    hits = np.array([True] * 37 + [False] * 9)
    alone = interval(hits, range(46))
    again = interval(np.repeat(hits, copies), np.repeat(np.arange(46), copies))
    assert again == pytest.approx(alone, abs=0.01)
    assert interval(np.repeat(hits, copies), range(46 * copies))[0] > alone[0] + 0.02  # had they been new
    assert interval(np.repeat([True] * 8, copies), np.repeat(np.arange(8), copies)) == interval(np.array([True] * 8), range(8))


def test_spread_between_laws_widens_an_interval_over_cases_of_them():
    """Eight laws always right and two always wrong say less than a hundred cases of which eighty are right."""
    hits = np.repeat([True] * 8 + [False] * 2, 10)
    low, high = interval(hits, np.repeat(np.arange(10), 10))
    assert low < 0.5 and high > 0.95
    mixed = interval(hits, np.tile(np.arange(10), 10))
    assert mixed == interval(hits, range(100))


def test_listings_are_pooled():
    listing = read(DOCS / "gap_bench/seventh.csv")
    rows = dict(pooled(listing))
    assert rows["singles: exact"].startswith("100 % (") and rows["singles: exact"].endswith("n = 14)")
    assert "triples: exact" not in rows
    both = dict(pooled([*listing, *read(DOCS / "gap_bench/sixth.csv")]))
    assert both["singles: exact"].startswith("88 % (") and both["singles: exact"].endswith("n = 34)")  # 14 and 16 of 14 and 20


def test_a_law_may_be_left_out(capsys):
    for but, count in (((), 19), (("snap", "three_waves"), 17)):
        main((DOCS / "gap_bench/tenth.csv",), but)
        (line,) = (line for line in capsys.readouterr().out.splitlines() if "called unknown" in line and "outside" in line)
        assert line.endswith(f"n = {count}) |")


def test_what_is_no_listing_is_refused(tmp_path):
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ConfigError, match="is no listing of the benchmark"):
        read(tmp_path / "other.csv")


def test_a_listing_without_what_is_needed_says_how_to_get_it():
    with pytest.raises(ConfigError, match="does not say strength, recorded_s, noise; the same `hamr gap bench` writes it anew"):
        read(DOCS / "gap_bench/seventh.csv", DATA)
