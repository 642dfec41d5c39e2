"""How the supervisor starts a node: python -m hamr_bringup.child SUPERVISOR_PID MODULE [ARGUMENT ...]

The node ends when its supervisor dies, however that dies; and when it is interrupted before it is up, it ends without a word.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import signal
import sys

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Run the node's main()."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(0))
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGINT, 0, 0, 0)
    _, supervisor, module, *arguments = sys.argv
    if os.getppid() == int(supervisor):
        sys.argv = [module, *arguments]
        importlib.import_module(module).main()


if __name__ == "__main__":
    main()
