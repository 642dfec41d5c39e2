"""The policy network: observations in their units, centred and scaled, then what stable-baselines3 builds."""

from __future__ import annotations

import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

from .observation import components


class Normalise(BaseFeaturesExtractor):
    """(value - centre) / scale, with the constants of `observation.FIELDS`: nothing to learn, nothing that drifts."""

    def __init__(self, observation_space: spaces.Box, view: str) -> None:
        rows = components(view)
        super().__init__(observation_space, len(rows))
        self.register_buffer("centre", torch.tensor([row["centre"] for row in rows]))
        self.register_buffer("scale", torch.tensor([row["scale"] for row in rows]))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return (observations - self.centre) / self.scale
