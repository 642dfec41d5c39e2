"""Numbers in shared memory that one process publishes and another waits for, in compiled code.

All functions are numba intrinsics or compiled from them: they run without the interpreter lock and are cached on disk.
"""

from __future__ import annotations

import platform

import llvmlite.binding
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

llvmlite.binding.initialize_native_asmparser()  # inline assembly aborts the process without it

_INT32, _INT64 = ir.IntType(32), ir.IntType(64)
_CLOCK_MONOTONIC = 1
_FIRST_PAUSES, _PAUSES = 10, 200  # before the first look at the peer's core, and in a round
_SYS_FUTEX = {"x86_64": 202, "aarch64": 98}[platform.machine()]
_FUTEX_WAIT, _FUTEX_WAKE = 0, 1
_PAUSE = {"x86_64": "pause", "aarch64": "yield"}[platform.machine()]


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
        builder.asm(ir.FunctionType(ir.VoidType(), []), _PAUSE, "", [], side_effect=True)
        return context.get_dummy_value()

    return types.void(), codegen


@intrinsic
def current_cpu(typingctx):
    """Number of the core that runs this."""

    def codegen(context, builder, signature, args):
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_INT32, []), "sched_getcpu")
        return builder.sext(builder.call(function, []), _INT64)

    return types.int64(), codegen


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
def fence(typingctx):
    """No read or write moves across, in either direction."""

    def codegen(context, builder, signature, args):
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), codegen


def _syscall(builder, *arguments):
    kind = ir.FunctionType(_INT64, [_INT64], var_arg=True)
    builder.call(cgutils.get_or_insert_function(builder.module, kind, "syscall"), [_INT64(_SYS_FUTEX), *arguments])


@intrinsic
def futex_wait(typingctx, words, index, seen, ns):
    """Sleep until woken while the lower half of words[index] is that of `seen`; ns below one second at most."""

    def codegen(context, builder, signature, args):
        words, index, seen, ns = args
        timespec = cgutils.alloca_once(builder, ir.ArrayType(_INT64, 2))
        for i, part in enumerate((_INT64(0), ns)):
            builder.store(part, cgutils.gep_inbounds(builder, timespec, 0, i))
        address = _pointer(context, builder, signature.args[0], words, index)
        _syscall(builder, address, _INT32(_FUTEX_WAIT), builder.trunc(seen, _INT32), timespec, timespec.type(None), _INT32(0))
        return context.get_dummy_value()

    return types.void(words, types.intp, types.int64, types.int64), codegen


@intrinsic
def futex_wake(typingctx, words, index):
    """Wake who sleeps on words[index]."""

    def codegen(context, builder, signature, args):
        address = _pointer(context, builder, signature.args[0], *args)
        nothing = ir.PointerType(_INT64)(None)
        _syscall(builder, address, _INT32(_FUTEX_WAKE), _INT32(1), nothing, nothing, _INT32(0))
        return context.get_dummy_value()

    return types.void(words, types.intp), codegen


@njit(cache=True, nogil=True)
def post(words, index, number, peer_waits):
    """Publish words[index] = number after all that was written before, and wake the peer if it sleeps."""
    store_release(words, index, number)
    fence()
    if load_acquire(words, peer_waits):
        futex_wake(words, index)


@njit(cache=True, nogil=True)
def await_number(words, index, wanted, waits, peer_cpu, rounds, limit_ns):
    """Wait until words[index] >= wanted; False after limit_ns (below one second).

    An answer that is on its way from another core is caught by spinning, for so many `rounds` of 5 us. Then, or at once where the peer was
    last seen on our own core, we sleep and the peer wakes us: it is preferred then to what else wants to run. Spinning on, or yielding,
    costs milliseconds on a busy machine.

    Args:
        words: (n,) int64.
        index: of the number waited for.
        waits: index of the flag that we sleep.
        peer_cpu: index of the number of the core that the peer ran on.
    """
    for _ in range(rounds):
        for _ in range(_FIRST_PAUSES):
            if load_acquire(words, index) >= wanted:
                return True
            pause()
        if words[peer_cpu] == current_cpu():
            break
        for _ in range(_PAUSES):
            if load_acquire(words, index) >= wanted:
                return True
            pause()
    deadline = monotonic_ns() + limit_ns
    while True:
        store_release(words, waits, 1)
        fence()
        seen = load_acquire(words, index)
        left = deadline - monotonic_ns()
        if seen >= wanted or left <= 0:
            store_release(words, waits, 0)
            return seen >= wanted
        futex_wait(words, index, seen, left)
