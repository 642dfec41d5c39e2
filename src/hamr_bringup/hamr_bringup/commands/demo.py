"""The main job, end to end: a policy walks on the residual simulator, then on HAMR-full behind the same topics.

Examples:
  hamr demo
  hamr demo --seconds 10 --out out/long --json
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    out: Path = Path("out/demo")
    """Folder for bags, video and plot."""
    seconds: float = 6.0
    """Simulated time on each backend."""
    policy: Path | None = None
    """Policy that walks; the shipped one if not given."""
    residual: Path | None = None
    """Residual model; the shipped one if not given."""

    def run(self) -> dict:
        from ..demo import demo
        from ..shipped import POLICY, RESIDUAL

        return demo(self.out, policy=self.policy or POLICY, residual=self.residual or RESIDUAL, seconds=self.seconds)
