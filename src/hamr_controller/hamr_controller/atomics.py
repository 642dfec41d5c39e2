"""Ordered loads and stores, pause, yield and a monotonic clock, for compiled code that shares memory between processes.

All functions are numba intrinsics or compiled from them: they run without the interpreter lock and are cached on disk.
"""

from __future__ import annotations

import llvmlite.binding
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

llvmlite.binding.initialize_native_asmparser()  # inline assembly aborts the process without it

_INT32, _INT64 = ir.IntType(32), ir.IntType(64)
_CLOCK_MONOTONIC = 1
_PAUSES_PER_YIELD = 200  # long enough to catch an answer in flight, short enough not to starve a peer on the same core
_SHORTEST_DOZE_NS, _LONGEST_DOZE_NS = 20_000, 2_000_000


def _pointer(context, builder, array_type, array, index):
    data = context.make_array(array_type)(context, builder, array).data
    return builder.gep(data, [index])


@intrinsic
def load_acquire(typingctx, array, index):
    """array[index] of an int64 array; later reads stay behind it."""

    def codegen(context, builder, signature, args):
        return builder.load_atomic(_pointer(context, builder, signature.args[0], *args), "acquire", 8)

    return types.int64(array, types.intp), codegen


@intrinsic
def store_release(typingctx, array, index, value):
    """array[index] = value of an int64 array; earlier writes stay before it."""

    def codegen(context, builder, signature, args):
        builder.store_atomic(args[2], _pointer(context, builder, signature.args[0], *args[:2]), "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), codegen


@intrinsic
def pause(typingctx):
    """The processor's hint that this is a spin loop."""

    def codegen(context, builder, signature, args):
        builder.asm(ir.FunctionType(ir.VoidType(), []), "pause", "", [], side_effect=True)
        return context.get_dummy_value()

    return types.void(), codegen


@intrinsic
def sched_yield(typingctx):
    """Let another process have this core."""

    def codegen(context, builder, signature, args):
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_INT32, []), "sched_yield")
        builder.call(function, [])
        return context.get_dummy_value()

    return types.void(), codegen


@intrinsic
def monotonic_ns(typingctx):
    """CLOCK_MONOTONIC in ns, the clock of time.monotonic_ns()."""

    def codegen(context, builder, signature, args):
        timespec = cgutils.alloca_once(builder, ir.ArrayType(_INT64, 2))
        clock = ir.FunctionType(_INT32, [_INT32, timespec.type])
        builder.call(cgutils.get_or_insert_function(builder.module, clock, "clock_gettime"), [_INT32(_CLOCK_MONOTONIC), timespec])
        seconds, ns = (builder.load(cgutils.gep_inbounds(builder, timespec, 0, i)) for i in range(2))
        return builder.add(builder.mul(seconds, _INT64(1_000_000_000)), ns)

    return types.int64(), codegen


@intrinsic
def sleep_ns(typingctx, ns):
    """Sleep; ns below one second."""

    def codegen(context, builder, signature, args):
        timespec = cgutils.alloca_once(builder, ir.ArrayType(_INT64, 2))
        for i, part in enumerate((_INT64(0), args[0])):
            builder.store(part, cgutils.gep_inbounds(builder, timespec, 0, i))
        function = ir.FunctionType(_INT32, [timespec.type, timespec.type])
        builder.call(cgutils.get_or_insert_function(builder.module, function, "nanosleep"), [timespec, timespec.type(None)])
        return context.get_dummy_value()

    return types.void(types.int64), codegen


@njit(cache=True, nogil=True)
def spin_until(words, index, wanted, limit_ns):
    """Spin until words[index] >= wanted, for the short waits inside a period; False after limit_ns."""
    deadline = 0
    while True:
        for _ in range(_PAUSES_PER_YIELD):
            if load_acquire(words, index) >= wanted:
                return True
            pause()
        now = monotonic_ns()
        if deadline == 0:
            deadline = now + limit_ns
        elif now >= deadline:
            return False
        sched_yield()


@njit(cache=True, nogil=True)
def doze_until(words, index, wanted, limit_ns):
    """The same for the long waits between periods: sleeps in steps of an eighth of the time already waited, so a core stays cool."""
    start = now = monotonic_ns()
    while load_acquire(words, index) < wanted:
        if now - start >= limit_ns:
            return False
        sleep_ns(min(max((now - start) // 8, _SHORTEST_DOZE_NS), _LONGEST_DOZE_NS))
        now = monotonic_ns()
    return True
