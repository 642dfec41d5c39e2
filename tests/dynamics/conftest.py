"""Simulators shared by the tests of the physics: a kernel is loaded once, its robots are set anew by each test."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def rng() -> np.random.Generator:
    """Seeded random numbers."""
    return np.random.default_rng(1)
