"""Machines with a hidden effect: the adversary of the gap workflow, with which it shares no effect code and no formula.

One suspended front-left leg of HAMR-simple in MuJoCo, laws of its own applied between the steps, and bags that do not tell;
`hidden_gap.ground` does the same with the whole robot, walking.
"""

from . import ground
from .bag import write
from .case import Case, Effect, Truth
from .draw import draw
from .noise import measured
from .simulate import commands, driven, simulate

__all__ = ["Case", "Effect", "Truth", "commands", "draw", "driven", "ground", "measured", "simulate", "write"]
