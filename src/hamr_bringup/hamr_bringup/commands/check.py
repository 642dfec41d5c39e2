"""Set every published fact about the robot beside this model's value: reference, tolerance, verdict, source, condition.

Examples:
  hamr check
  hamr check --json
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    def run(self) -> dict:
        from hamr_sim_full.check import check

        return check()
