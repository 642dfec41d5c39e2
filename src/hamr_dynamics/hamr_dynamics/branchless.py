"""In compiled code: choices between two numbers as single instructions. A conditional expression means the same and runs as fast, but each
makes new blocks of code, and numba's time to compile grows with blocks times lines."""

from __future__ import annotations

from llvmlite import ir
from numba.extending import intrinsic


@intrinsic
def larger(typingctx, a, b):
    """a if a > b else b."""

    def emit(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)

    return a(a, a), emit


@intrinsic
def smaller(typingctx, a, b):
    """a if a < b else b."""

    def emit(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered("<", *arguments), *arguments)

    return a(a, a), emit


@intrinsic
def gate(typingctx, a):
    """1 if a > 0 else 0."""

    def emit(context, builder, signature, arguments):
        (x,) = arguments
        one, zero = (ir.Constant(x.type, value) for value in (1.0, 0.0))
        return builder.select(builder.fcmp_ordered(">", x, zero), one, zero)

    return a(a), emit
