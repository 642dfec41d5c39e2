"""A short training, shared by the tests that need a policy."""

from __future__ import annotations

from pathlib import Path

import pytest

from hamr_policy.train import train

#: Short updates, so that two checkpoints lie within a second.
SHORT = {"robots": 32, "rollout": 4, "batch": 64, "epochs": 1}
STEPS = 32 * 4 * 110


@pytest.fixture(scope="session")
def trained(tmp_path_factory) -> Path:
    """Folder of a short training on HAMR-simple."""
    out = tmp_path_factory.mktemp("trained")
    train("walk", "simple", out, steps=STEPS, seed=3, **SHORT)
    return out
