"""Answers to servo samples as compiled callbacks, for engines that run the substeps of a period in one compiled loop.

An engine that has `servo_period(answer, memory, samples, volts, k) -> int` is stepped through it. For the samples i = k.. of a period it
measures into samples[i], calls `answer(memory, i, samples[i], volts[i])`, and holds volts[i] for one substep; it returns 80, or the i whose
answer was False: measured, but not stepped. The callbacks have one signature, so that such a loop is compiled once and cached.
"""

from __future__ import annotations

from functools import cache

import numba
import numpy as np
from numba import types

from . import bus
from .law import signed_law
from .plan import JOINT_COUNT as N
from .plan import PLAN_FEED as FEED

#: bool answer(memory (.,), i, sample (7, 8), volts (8,)); memory is what the answer comes from.
SIGNATURE = types.boolean(types.float64[::1], types.int64, types.float64[:, ::1], types.float64[::1])
SLICE_NS = 20_000_000  # longest stay in compiled code: signals and dead peers are noticed after it


@cache
def over_the_bus():
    """Answers come from the driver; memory is the mapped bus as float64."""

    @numba.cfunc(SIGNATURE, cache=True)
    def answer(memory, i, sample, volts):
        words = memory.view(np.int64)
        return bus.exchange(words, memory, bus.number_in_period(words, i), sample, volts, SLICE_NS)

    return answer


@cache
def by_plan():
    """Answers come from a plan; memory is `Plan.memory`."""

    @numba.cfunc(SIGNATURE, cache=True)
    def answer(memory, i, sample, volts):
        target, kp, kd = memory[FEED : FEED + N], memory[FEED + N : FEED + 2 * N], memory[FEED + 2 * N : FEED + 3 * N]
        signed_law(memory[i * N : (i + 1) * N], target, sample[0], sample[1], kp, kd, volts)
        return True

    return answer
