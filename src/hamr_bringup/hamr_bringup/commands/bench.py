"""Measure speeds side by side in one run and print ratios: kernels against MuJoCo, policy periods, start-up.

Examples:
  hamr bench
  hamr bench --json
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    def run(self) -> dict:
        from ..bench import bench

        return bench()
