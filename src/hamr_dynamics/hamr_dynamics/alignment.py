"""Memory on cache lines: vectors that straddle two lines cost twice, and what a kernel computes passes through memory more than once."""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

LINE_BYTES = 64  # of a cache line, and of the longest vector


@njit(inline="always")
def aligned(size, dtype):
    """Uninitialised array (size,) that begins on a cache line."""
    buffer = np.empty(size + LINE_BYTES, dtype)
    first = (LINE_BYTES - buffer.ctypes.data % LINE_BYTES) // buffer.itemsize
    return buffer[first : first + size]


@intrinsic
def align_stack(typingctx):
    """In compiled code: begins the caller's stack frame on a cache line, and with it what does not fit the registers."""

    def emit(context, builder, signature, arguments):
        with builder.goto_entry_block():
            slot = builder.alloca(ir.ArrayType(ir.IntType(8), LINE_BYTES))
            slot.align = LINE_BYTES
        address = builder.ptrtoint(slot, ir.IntType(64))
        builder.asm(ir.FunctionType(ir.VoidType(), [ir.IntType(64)]), "", "r", [address], side_effect=True)  # keeps the slot alive
        return context.get_dummy_value()

    return types.void(), emit
