"""Say what this machine lacks for HAMR, and how to get it.

Examples:
  hamr doctor
  hamr doctor --json
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    def run(self) -> dict:
        from ..doctor import rows

        found = rows()
        return {"ok": all(row["ok"] for row in found), "rows": found}
