"""Hidden cases that walk: the whole HAMR-simple on the ground, as a laboratory with encoders and motion capture would record it."""

from .bag import write
from .case import GroundCase
from .draw import GROUPS, draw, turn

__all__ = ["GROUPS", "GroundCase", "draw", "turn", "write"]
