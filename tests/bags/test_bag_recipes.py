"""The recipes in bags/ can be made: known kinds, known parameters, and no signal of the training bag among those held out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import yaml

from hamr_bags.excitation import excitation
from hamr_bags.frames import SAMPLES_PER_FRAME

BAGS = Path(__file__).parents[2] / "bags"
RECIPES = yaml.safe_load((BAGS / "recipes.yaml").read_text())


def test_every_recipe_is_a_signal_and_has_a_digest():
    signals = RECIPES["training"] | RECIPES["held_out"]
    made = {name: excitation(**parameters) for name, parameters in signals.items()}
    assert set(json.loads((BAGS / "digests.json").read_text())) == set(made)
    assert RECIPES["common"]["samples_per_frame"] in SAMPLES_PER_FRAME
    assert len({found.voltages.tobytes() for found in made.values()}) == len(made)


def test_held_out_signals_are_not_the_training_signal():
    """Not even a stretch of it: correlations over one second are those of independent signals."""
    (training,) = (excitation(**parameters).voltages[10_000:30_000] for parameters in RECIPES["training"].values())
    for parameters in RECIPES["held_out"].values():
        held_out = excitation(**parameters).voltages[-20_000:]
        correlation = [np.corrcoef(training[:, j], held_out[:, j])[0, 1] for j in range(8)]
        assert np.abs(correlation).max() < 0.5
