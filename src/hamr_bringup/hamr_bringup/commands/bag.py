"""Check, repair, describe or flatten a bag.

Examples:
  hamr bag check out/noise
  hamr bag repair out/noise --out out/noise_whole
  hamr bag info out/noise --json
  hamr bag flatten out/noise
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

Bag = Positional[Annotated[Path, arg(metavar="BAG", help="Bag folder or .mcap file.")]]


@dataclass(frozen=True, slots=True)
class Check:
    """Prove counts, order, gaps and clocks; fails if one of them is wrong."""

    bag: Bag

    def run(self) -> dict:
        from hamr_bags import cli

        return cli.check(self.bag)


@dataclass(frozen=True, slots=True)
class Repair:
    """Rescue what a truncated or damaged bag still holds into a new one."""

    bag: Bag
    out: Path | None = None
    """The new bag; by default beside the old one."""

    def run(self) -> dict:
        from hamr_bags import cli

        return cli.repair(self.bag, self.out)


@dataclass(frozen=True, slots=True)
class Info:
    """Say what a bag holds: topics, types, counts, rates, and what /run_info says."""

    bag: Bag

    def run(self) -> dict:
        from hamr_bags import cli

        return cli.info(self.bag)


@dataclass(frozen=True, slots=True)
class Flatten:
    """Write one JointState per sample, for plotting tools."""

    bag: Bag
    out: Path | None = None
    """The new bag; by default beside the old one, with _flat added to its name."""

    def run(self) -> dict:
        from hamr_bags import cli

        return cli.flatten(self.bag, self.out)


Command = {"check": Check, "repair": Repair, "info": Info, "flatten": Flatten}
