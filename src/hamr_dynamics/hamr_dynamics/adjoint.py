"""Reverse mode on a trace: from a stage, the stage that pulls gradients back through it."""

from __future__ import annotations

from collections.abc import Sequence

from . import scalar
from .emit import Stage
from .trace import Var


def pullback(stage: Stage, wrt: Sequence[str]) -> Stage:
    """The stage `(inputs, grad_OUT for each output array) -> grad_IN for each array of wrt`.

    Gates (`positive`) and steps (`floor`) have derivative zero; `max` and `min` pass the gradient to the operand that was chosen.
    """
    graph = stage.graph
    seeds = {f"grad_{array}": rows for array, rows in stage.outputs.items()}
    outputs = {f"grad_{a}": stage.inputs[a] for a in wrt}
    back = Stage(f"{stage.name}_pullback", {**stage.inputs, **seeds}, outputs, graph, uniform=stage.uniform)
    forward = graph.needed(stage.values.values())
    gradient: dict[int, Var | float] = {}

    def add(target, amount) -> None:
        if isinstance(target, int):
            gradient[target] = gradient[target] + amount if target in gradient else amount

    for (array, row), value in stage.values.items():
        if isinstance(value, Var):
            add(value.index, back.read(f"grad_{array}", row))

    for i in reversed(forward):
        op, args = graph.nodes[i]
        if op in ("input", "positive", "floor") or i not in gradient:
            continue
        g = gradient[i]
        a, b = ([Var(graph, x) if isinstance(x, int) else x for x in args] + [None])[:2]
        for target, amount in zip(args, _PARTIALS[op](g, a, b, Var(graph, i)), strict=True):
            add(target, amount)

    for array in wrt:
        for row in stage.inputs[array]:
            leaf = graph.input(f"{array}.{row}").index
            back.write(f"grad_{array}", row, gradient.get(leaf, 0.0))
    return back


def _chosen(g, a, b):
    gate = scalar.positive(a - b)
    return g * gate, g * (1.0 - gate)


_PARTIALS = {
    "add": lambda g, a, b, y: (g, g),
    "sub": lambda g, a, b, y: (g, -g),
    "mul": lambda g, a, b, y: (g * b, g * a),
    "div": lambda g, a, b, y: (g / b, -(g * y / b)),
    "neg": lambda g, a, b, y: (-g,),
    "sqrt": lambda g, a, b, y: (0.5 * g / y,),
    "max": lambda g, a, b, y: _chosen(g, a, b),
    "min": lambda g, a, b, y: _chosen(g, b, a),
}
