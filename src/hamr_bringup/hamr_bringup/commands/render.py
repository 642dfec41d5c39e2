"""Make a video from any bag with hip angles; several bags become pictures side by side.

Examples:
  hamr render out/walk --out out/walk.mp4
  hamr render out/residual out/full --out out/both.mp4 --slow 10 --seconds 1 --camera side
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg


@dataclass(frozen=True, slots=True)
class Command:
    bag: Positional[Annotated[Path, arg(metavar="BAG")]]
    """Bag folder or .mcap file."""
    out: Path
    """The video, ending in .mp4."""
    more: Positional[Annotated[tuple[Path, ...], arg(metavar="[BAG ...]")]] = ()
    """Bags to show beside it."""
    slow: float = 4.0
    """Seconds of video per second of the robot."""
    seconds: float = inf
    """Seconds of the robot, from the start."""
    camera: str = "track"
    """track, overview, side or top."""

    def run(self) -> dict:
        from ..render import render

        return render([self.bag, *self.more], self.out, slow=self.slow, seconds=self.seconds, camera=self.camera)
