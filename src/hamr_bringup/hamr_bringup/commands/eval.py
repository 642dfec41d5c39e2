"""Say what policies do on the backend they were trained on, and on others: speeds, turning rates, rewards, with spread.

Examples:
  hamr eval policy out/walk/policy.onnx --residual out/residual.json
  hamr eval policy out/seed_*/policy.onnx --backend full simple --json
  hamr eval policy out/walk/policy.onnx --backend simple --effects effects.yaml
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg


@dataclass(frozen=True, slots=True)
class Policy:
    """Roll policies out; those of equal task and training are seeds of one and the same."""

    policy: Positional[Annotated[Path, arg(metavar="POLICY")]]
    """ONNX file of a policy."""
    more: Positional[Annotated[tuple[Path, ...], arg(metavar="[POLICY ...]")]] = ()
    """Policies of other training seeds, tasks or backends."""
    backend: Annotated[tuple[str, ...], arg(metavar="BACKEND [BACKEND ...]")] = ("full",)
    """To run on, besides the one it was trained on: full, residual, simple, simple_published."""
    residual: str = ""
    """Residual model file; the shipped one if not given."""
    effects: str = ""
    """Effects file: what is added to the backends of --backend (docs/effects.md)."""
    trained_with: str = ""
    """Effects file that the policies were trained with, for the runs on their own backend."""
    rollouts: int = 5
    """From different random starts, per policy and direction."""
    seed: int = 0
    """Of the starts."""

    def run(self) -> dict:
        from hamr_policy.evaluate import evaluate

        policies = [self.policy, *self.more]
        return evaluate(policies, self.backend, residual=self.residual, effects=self.effects, trained_with=self.trained_with,
                        rollouts=self.rollouts, seed=self.seed)  # fmt: skip


Command = {"policy": Policy}
