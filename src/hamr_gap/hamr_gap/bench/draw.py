"""One case drawn, in a process of its own: python -m hamr_gap.bench.draw OUT GROUP SET INDEX STRENGTH SECONDS"""

from __future__ import annotations

import sys
from pathlib import Path

from .cases import make

if __name__ == "__main__":
    out, group, set_, index, strength, seconds = sys.argv[1:]
    make(Path(out), group, set_, int(index), strength=float(strength), seconds=float(seconds))
