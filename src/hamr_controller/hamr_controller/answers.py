"""Answers to servo samples as compiled callbacks, for engines that run the substeps of a period in one compiled loop.

Such an engine has `servo_period(answer, memory, samples, volts, k) -> int`. The voltages volts[k] are there. It holds them for one
substep, measures into samples[k + 1], calls `answer(memory, k + 1, samples[k + 1], volts[k + 1])`, and so on to the end of the period;
it returns 80, or the number of the sample that `answer` had none for, to be called again with when its voltages are there. So every
substep of a run is made by the same machine code, whatever the timing. The callbacks have one signature: the loop is compiled once.
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
