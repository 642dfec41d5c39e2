"""Straight-line code over lanes, compiled into its caller. numba would type and analyse line by line what LLVM takes as it is, and need
a minute for a kernel that LLVM compiles in seconds."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from inspect import Parameter, Signature

from llvmlite import ir
from numba import types
from numba.core.cgutils import for_range
from numba.extending import intrinsic

INDEX = ir.IntType(64)
BINARY = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}


def over_lanes(arrays: str, text: str):
    """A function of arrays, to be called in compiled code, of the text that is its body (`emit.loop_body`).

    Choices become single instructions, so that a loop stays without branches and LLVM makes vectors of it.

    Args:
        arrays: its arguments by name: contiguous ones of one type of float.
        text: assignments to names and to places of arrays, last a loop over lanes of such; it means what it would in plain Python.
    """
    names, (*before, loop) = arrays.split(", "), ast.parse(text).body
    lanes = ir.Constant(INDEX, loop.iter.args[0].value)

    def function(typingctx, *kinds):
        def emit(context, builder, signature, arguments):
            begin = {n: context.make_array(k)(context, builder, a).data for n, k, a in zip(names, kinds, arguments, strict=True)}
            code = _Code(builder, begin, context.get_data_type(kinds[0].dtype))
            code.run(before, None)
            with for_range(builder, lanes) as each:
                code.run(loop.body[1:], each.index)  # the first line says what e is
            return context.get_dummy_value()

        return types.void(*kinds), emit

    function.__signature__ = Signature([Parameter(name, Parameter.POSITIONAL_ONLY) for name in ("typingctx", *names)])
    return intrinsic(function)


class _Code:
    """Statements as instructions."""

    def __init__(self, builder: ir.IRBuilder, arrays: Mapping[str, ir.Value], real: ir.Type) -> None:
        self._builder, self._arrays, self._real = builder, arrays, real
        self._values: dict[str, ir.Value] = {}

    def run(self, statements: Sequence[ast.Assign], lane: ir.Value | None) -> None:
        """All of them, in one lane."""
        for statement in statements:
            (target,), value = statement.targets, self._value(statement.value, lane)
            if isinstance(target, ast.Name):
                self._values[target.id] = value
            else:
                self._builder.store(value, self._place(target, lane))

    def _value(self, node: ast.expr, lane: ir.Value | None) -> ir.Value:
        builder = self._builder
        match node:
            case ast.Name(name):
                return self._values[name]
            case ast.Subscript():
                return builder.load(self._place(node, lane), typ=self._real)
            case ast.UnaryOp(ast.USub(), of):
                return builder.fneg(self._value(of, lane))
            case ast.BinOp(a, op, b) if type(op) in BINARY:
                return getattr(builder, BINARY[type(op)])(self._value(a, lane), self._value(b, lane))
            case ast.Call(ast.Name("real"), [number]):
                return ir.Constant(self._real, float(ast.literal_eval(number)))
            case ast.Call(ast.Name("sqrt" | "floor" as name), [of]):
                return builder.call(builder.module.declare_intrinsic(f"llvm.{name}", [self._real]), [self._value(of, lane)])
            case ast.Call(ast.Name("larger" | "smaller" as name), of):
                a, b = (self._value(each, lane) for each in of)
                return builder.select(builder.fcmp_ordered(">" if name == "larger" else "<", a, b), a, b)
            case ast.Call(ast.Name("gate"), [of]):
                one, zero = (ir.Constant(self._real, x) for x in (1.0, 0.0))
                return builder.select(builder.fcmp_ordered(">", self._value(of, lane), zero), one, zero)
        raise ValueError(f"straight-line code has no '{ast.unparse(node)}'.")

    def _place(self, node: ast.Subscript, lane: ir.Value | None) -> ir.Value:
        """Where array[U(row)] or array[U(row)+e] lies."""
        match node.slice:
            case ast.BinOp(ast.Call(_, [ast.Constant(row)]), ast.Add(), ast.Name("e")):
                at = self._builder.add(lane, ir.Constant(INDEX, row), flags=("nuw", "nsw"))
            case ast.Call(_, [ast.Constant(row)]):
                at = ir.Constant(INDEX, row)
            case _:
                raise ValueError(f"'{ast.unparse(node)}' is no place of a row.")
        return self._builder.gep(self._arrays[node.value.id], [at], inbounds=True, source_etype=self._real)
