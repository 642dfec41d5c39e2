"""mj_step in a compiled loop, for benchmarks: what MuJoCo costs without Python."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path

import mujoco
from numba import njit


@cache
def compiled_step_loop() -> Callable[[int, int, int], None]:
    """(model address, data address, n): runs n steps of mj_step without the interpreter and its lock.

    Addresses are `_address` of an MjModel and an MjData, which must stay alive meanwhile.
    """
    step = ctypes.CDLL(str(_library())).mj_step
    step.argtypes, step.restype = [ctypes.c_void_p, ctypes.c_void_p], None

    @njit(nogil=True)
    def loop(model: int, data: int, n: int) -> None:
        for _ in range(n):
            step(model, data)

    return loop


def _library() -> Path:
    """The shared library of the installed mujoco package (Linux, macOS or Windows)."""
    version = mujoco.mj_versionString()
    names = (f"libmujoco.so.{version}", f"libmujoco.{version}.dylib", "mujoco.dll")
    folder = Path(mujoco.__file__).parent
    return next(path for path in map(folder.joinpath, names) if path.exists())
