"""The map of power, on outcomes drawn from a curve that is known."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.special import expit, logit

from hamr_description.errors import ConfigError
from hamr_gap.bench.listing import COLUMNS, VERDICT
from hamr_gap.bench.power import WANTED, main, outcomes, power

EASY, HARD, SLOPE = 2.0, -1.0, 2.2  # log odds at a strength of one floor; per factor e


def drawn(count: int, seed: int) -> list[tuple[str, float, float, float, bool]]:
    random = np.random.default_rng(seed)
    cases = []
    for _ in range(count):
        family = ("easy", "hard")[random.integers(2)]
        strength, seconds, noise = np.exp(random.uniform(np.log(0.2), np.log(8.0))), (3.0, 12.0)[random.integers(2)], 3e-3
        odds = {"easy": EASY, "hard": HARD}[family] + SLOPE * np.log(strength) + 0.8 * np.log(seconds / 12.0)
        cases.append((family, strength, seconds, noise, bool(random.random() < expit(odds))))
    return cases


def test_strengths_come_back_with_intervals_that_hold_them():
    held = []
    for seed in range(20):
        found = power(drawn(400, seed))
        for family, own in (("easy", EASY), ("hard", HARD)):
            for seconds in (3.0, 12.0):
                exact = np.exp((logit(WANTED) - own - 0.8 * np.log(seconds / 12.0)) / SLOPE)
                x, low, high = found.needed(family, seconds)
                assert x == pytest.approx(exact, rel=0.6)
                held.append(low < exact < high)
    assert np.mean(held) > 0.88


def test_nothing_is_said_beyond_the_strengths_that_were_tried():
    """Also where strength seems to do harm, as it may by chance."""
    sure = [("sure", x, 12.0, 3e-3, True) for x in (1.0, 5.0) * 40]
    lost = [("lost", x, 12.0, 3e-3, x < 2.0 and k % 3 > 0) for k in range(20) for x in (1.0, 5.0)]
    found = power([*sure, *lost])
    assert found.said("sure", 12.0, (1.0, 5.0)) == "< 1"
    assert found.said("lost", 12.0, (1.0, 5.0)) == "> 5"
    drawn_well = power(drawn(400, 3))
    x, low, high = drawn_well.needed("hard")
    assert drawn_well.said("hard", 12.0, (0.2, 8.0)) == f"{x:.2g} ({low:.2g}..{min(high, 8.0):.2g})"


def test_a_family_that_was_never_missed_needs_less_than_one_that_was():
    found = power([("sure", 5.0, 12.0, 3e-3, True)] * 20 + [("unsure", 5.0, 12.0, 3e-3, k % 2 == 0) for k in range(20)])
    assert found.needed("sure")[0] < 0.5 * found.needed("unsure")[0]


def listed(path, cases, columns=COLUMNS):
    """A listing of cases, with one pair among them."""
    with path.open("w", newline="") as file:
        out = csv.DictWriter(file, columns, restval="0", extrasaction="ignore")
        out.writeheader()
        out.writerow({"group": "pair", "hidden": "easy (fl_lift) + hard (fl_lift)", "right": "1"})
        for family, strength, seconds, noise, right in cases:
            line = {"group": "single", "hidden": f"{family} (fl_lift, fl_swing)", "right": int(right)}
            out.writerow(line | {"strength": strength, "recorded_s": seconds, "noise": noise})
    return path


def test_the_map_is_made_of_listings(tmp_path, capsys):
    """The single effects of all files, as a table of what each needs and as a picture."""
    cases = drawn(200, 1)
    halves = [listed(tmp_path / f"{k}.csv", cases[k::2]) for k in (0, 1)]
    assert sorted(outcomes(halves)) == sorted(cases)
    main(tuple(halves), tmp_path / "map.png")
    table = capsys.readouterr().out.splitlines()
    assert table[0] == "| effect | right | 3 s | 12 s |"
    found, tried = power(cases), (min(c[1] for c in cases), max(c[1] for c in cases))
    counts = {family: [right for name, *_, right in cases if name == family] for family in found.families}
    assert table[2:4] == [
        f"| `{family}` | {sum(own)} of {len(own)} | {found.said(family, 3.0, tried)} | {found.said(family, 12.0, tried)} |"
        for family, own in counts.items()
    ]
    assert imread(tmp_path / "map.png").shape[2] == 4


def test_listings_that_cannot_tell_are_refused(tmp_path):
    with pytest.raises(ConfigError, match="does not say strength"):
        outcomes([listed(tmp_path / "old.csv", [], VERDICT)])
    with pytest.raises(ConfigError, match="No solved case with a single effect"):
        outcomes([listed(tmp_path / "pairs.csv", [])])
