"""The same from 6 s of others: singles, a pair, laws outside the library, and coloured noise."""

from __future__ import annotations

from smoke import cases, is_found_and_placed, solved


@cases("single", "pair", seconds=6.0)
def test_hidden_effects_are_found_and_placed(case):
    is_found_and_placed(case)


@cases("outside", seconds=6.0)
def test_a_law_outside_the_library_is_said_to_be_one(case):
    assert solved(case).verdict.verdict == "unknown"


@cases("null", seconds=6.0)
def test_noise_that_is_not_white_is_no_effect(case):
    assert case.noise_kind != "white"
    assert solved(case).verdict.verdict == "no_significant_gap"
