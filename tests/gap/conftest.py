"""A leg that several tests of the search look at."""

from __future__ import annotations

import pytest
from shaken_leg import shaken

from hamr_gap.legs import machine_of
from hamr_gap.naming.prepare import Prepared, prepare


@pytest.fixture(scope="session")
def rubbing() -> Prepared:
    """A leg with friction in its swing joint."""
    return prepare(machine_of("simple", "fl"), shaken("coulomb_friction.presliding", {"level.0": 4e-3, "distance.0": 0.005}))
