"""What HAMR-full has that HAMR-simple lacks, as the library's laws hold it."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_dynamics.effects.law import Pair
from hamr_gap.flagship import EFFECTS, ablate, differences
from hamr_gap.legs import machine_of


@pytest.fixture(scope="module")
def legs():
    return machine_of("simple", "fl"), machine_of("full", "fl")


@pytest.fixture(scope="module")
def truth(legs):
    return differences(*legs)


def test_only_the_whole_group_closes_the_gap(legs, truth):
    errors = ablate(*legs, truth, seconds=3.0, seed=3)
    lower = {group: errors[()][1] / short for group, (_, short) in errors.items()}
    assert lower.pop(("inertia", "stiffness", "transmission")) > 1000.0
    assert lower["transmission",] > 10.0
    assert max(lower.values()) < 50.0
    assert max(lower["inertia",], lower["stiffness",], lower["inertia", "stiffness"]) < 1.0  # worse than nothing


@pytest.mark.parametrize("q", [(0.4, -0.3), (-0.35, -0.4), (0.1, 0.35)])
def test_the_lever_is_that_of_the_linkage(legs, truth, q):
    """Tips and drive against full's closed form: travels of the third degree are off by 0.0008 mm and 3 %."""
    simple, full = legs
    zero, u, stem = (0.0, 0.0), (50.0, -30.0), "configuration_dependent_transmission.fine_map."
    p = {row.removeprefix(stem).removesuffix(".0"): x for row, x in truth["transmission"].items()}
    drive = simple.terms(q, zero, zero, u).drive
    pushes = [EFFECTS["transmission"].law.law(Pair(q, zero, d, (0.5, 0.6), zero, 0.05), p, ())[0] for d in (drive, zero)]
    assert simple.outputs(q, pushes[0].slip)[2:] == pytest.approx(full.outputs(q, zero)[2:], abs=5e-5)  # mm, of 0.25
    added = np.subtract(pushes[0].force, pushes[1].force)
    np.testing.assert_allclose(drive + added, full.terms(q, zero, zero, u).drive, atol=0.002 * max(np.abs(drive)))
