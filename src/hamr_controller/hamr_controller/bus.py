"""The servo bus: 80 exchanges in every 4 ms period between simulator (samples) and driver (voltages), 20 kHz through shared memory.

Samples are numbered from the start of the simulator; a driver answers a number with voltages under the same number. A number is used
once in the life of a file, so a late answer is recognised and ignored. Payload first, number last (release); number first, payload
after (acquire). Each end writes cache lines of its own:

    byte 0    header (hamr_controller.bus_file)
    byte 128  simulator: number of the newest sample, its core, whether it sleeps; byte 192: hip angles, hip rates
    byte 384  driver: number answered, its core, whether it sleeps, count of drivers that joined, process id; byte 448: voltages
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

from hamr_description.names import JOINTS
from hamr_description.rates import SUBSTEPS

from .atomics import await_number, current_cpu, load_acquire, post
from .law import signed_law
from .plan import Plan

SAMPLE_WORD, SIMULATOR_CPU, SIMULATOR_WAITS, SAMPLE_REALS = 16, 17, 18, 24
ANSWER_WORD, DRIVER_CPU, DRIVER_WAITS, JOINS_WORD, DRIVER_PID_WORD, VOLT_REALS = 48, 49, 50, 51, 52, 56
_ROUNDS = 20  # of spinning within a period: 0.1 ms, longer than a substep of any engine
LOST = -1
_N = len(JOINTS)


def first_number(period: int) -> int:
    """Number of the first sample of a period; numbers start at 1 and are 64 bits wide: 14 million years of servo samples."""
    return period * SUBSTEPS + 1


@njit(cache=True, nogil=True)
def number_in_period(words, i):
    """Simulator: number of sample i of the period offered last."""
    return (words[SAMPLE_WORD] - 1) // SUBSTEPS * SUBSTEPS + 1 + i


@njit(cache=True, nogil=True)
def post_sample(words, reals, number, sample):
    """Simulator: publish a sample, rows (., 8) SI, of which the first two (hip angles, rates) cross the bus."""
    for j in range(_N):
        reals[SAMPLE_REALS + j] = sample[0, j]
        reals[SAMPLE_REALS + _N + j] = sample[1, j]
    words[SIMULATOR_CPU] = current_cpu()
    post(words, SAMPLE_WORD, number, DRIVER_WAITS)


@njit(cache=True, nogil=True)
def take_answer(words, reals, number, volts):
    """Simulator: copy the voltages (8,) if they answer this number; whether they did."""
    if load_acquire(words, ANSWER_WORD) != number:
        return False
    for j in range(_N):
        volts[j] = reals[VOLT_REALS + j]
    return True


@njit(cache=True, nogil=True)
def await_answer(words, number, rounds, limit_ns):
    """Simulator: wait for the answer with a number (or a later one); whether it came."""
    return await_number(words, ANSWER_WORD, number, SIMULATOR_WAITS, DRIVER_CPU, rounds, limit_ns)


@njit(cache=True, nogil=True)
def await_sample(words, number, rounds, limit_ns):
    """Driver: wait for the sample with a number (or a later one); whether it came."""
    return await_number(words, SAMPLE_WORD, number, DRIVER_WAITS, SIMULATOR_CPU, rounds, limit_ns)


@njit(cache=True, nogil=True)
def exchange(words, reals, number, sample, volts, limit_ns):
    """Simulator: publish a sample and wait for its voltages; False when none came within the limit."""
    post_sample(words, reals, number, sample)
    return await_answer(words, number, _ROUNDS, limit_ns) and take_answer(words, reals, number, volts)


@njit(cache=True, nogil=True)
def drive(words, reals, first, k, feed, target, kp, kd, volts, limit_ns):
    """Driver: answer samples k.. of the period whose first sample has number `first` by the leg law.

    Args:
        words: (64,) int64 and reals: (64,) float64, the mapped file.
        first: number of the period's first sample.
        k: sample to begin with.
        feed: (80, 8) V, the open-loop part.
        target: (8,) rad; kp, kd: (8,) as `Gains.per_joint`.
        volts: (80, 8) V, filled.
        limit_ns: longest wait for one sample.

    Returns:
        The sample that did not come in time, to call again with; 80 when done; LOST when the simulator has gone on without us.
    """
    position, velocity = reals[SAMPLE_REALS : SAMPLE_REALS + _N], reals[SAMPLE_REALS + _N : SAMPLE_REALS + 2 * _N]
    answer = reals[VOLT_REALS : VOLT_REALS + _N]
    for i in range(k, SUBSTEPS):
        if not await_sample(words, first + i, _ROUNDS, limit_ns):
            return i
        if load_acquire(words, SAMPLE_WORD) != first + i:
            return LOST
        signed_law(feed[i], target, position, velocity, kp, kd, volts[i])
        answer[:] = volts[i]
        words[DRIVER_CPU] = current_cpu()
        post(words, ANSWER_WORD, first + i, SIMULATOR_WAITS)
    return SUBSTEPS


@cache
def warm_up() -> None:
    """Compile, or load from the cache, what both ends call: seconds that belong before the first period, and no more after it."""
    words, reals, sample, volts = np.zeros(64, np.int64), np.zeros(64), np.zeros((2, _N)), np.zeros((SUBSTEPS, _N))
    plan = Plan.neutral()
    calls = {
        post_sample: (words, reals, 0, sample),
        await_answer: (words, 1, 1, 0),
        await_sample: (words, 1, 1, 0),
        take_answer: (words, reals, 1, volts[0]),
        exchange: (words, reals, 1, sample, volts[0], 0),
        drive: (words, reals, 1, 0, plan.feed, plan.target, plan.kp, plan.kd, volts, 0),
    }
    for function, arguments in calls.items():
        function(*arguments)
        function.disable_compile()  # other types of arguments are a mistake, and must not cost seconds amid a run
