"""A short training, shared by the tests that need a policy."""

from __future__ import annotations

from pathlib import Path

import pytest

from hamr_policy.train import train

#: As few and as short updates as PPO takes; two checkpoints lie within.
SHORT = {"robots": 32, "rollout": 8, "batch": 64, "epochs": 2}
STEPS = 32 * 8 * 20


@pytest.fixture(scope="session")
def trained(tmp_path_factory) -> Path:
    """Folder of a short training on HAMR-simple."""
    out = tmp_path_factory.mktemp("trained")
    train("walk", "simple", out, steps=STEPS, seed=3, **SHORT)
    return out
