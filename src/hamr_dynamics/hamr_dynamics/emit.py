"""Turns a traced graph into the source of a compiled loop over lanes.

Each array is flat: row r of lane e lies at r * L + e with L a literal, so that the loop over lanes has a straight-line body
on unit strides and LLVM makes vectors of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from .trace import Graph, Var

_FORMAT = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{} * {}",
    "div": "{} / {}",
    "neg": "-{}",
    "sqrt": "sqrt({})",
    "max": "({0} if {0} > {1} else {1})",
    "min": "({0} if {0} < {1} else {1})",
    "positive": "(ONE if {0} > ZERO else ZERO)",
}


@dataclass(slots=True)
class Stage:
    """A traced function from some arrays to others.

    Attributes:
        name: of the emitted function.
        inputs, outputs: array name -> row names, in order of the arguments; no array is both.
        graph: the trace.
        values: (array, row) -> traced output.
        uniform: inputs that have one value for all lanes: row r lies at r.
    """

    name: str
    inputs: Mapping[str, Sequence[str]]
    outputs: Mapping[str, Sequence[str]]
    graph: Graph = field(default_factory=Graph)
    values: dict[tuple[str, str], Var | float] = field(default_factory=dict)
    uniform: frozenset[str] = frozenset()

    def read(self, array: str, row: str) -> Var:
        """An input row as a traced scalar."""
        if row not in self.inputs[array]:
            raise KeyError(f"{self.name}: no row '{row}' in '{array}'")
        return self.graph.input(f"{array}.{row}")

    def reads(self, array: str, name: str, n: int) -> tuple:
        """Rows name.0 ... name.(n-1)."""
        return tuple(self.read(array, f"{name}.{i}") for i in range(n))

    def write(self, array: str, name: str, value) -> None:
        """Output rows: a scalar, or a tuple as name.0, name.1, ..."""
        if isinstance(value, tuple):
            for i, x in enumerate(value):
                self.write(array, f"{name}.{i}", x)
        elif name not in self.outputs[array]:
            raise KeyError(f"{self.name}: no row '{name}' in '{array}'")
        else:
            self.values[array, name] = value


def loop_source(stage: Stage, lanes: int) -> str:
    """Python source of `def NAME(inputs..., outputs...)`: the stage over all lanes. Needs U, sqrt, real, ONE and ZERO in scope."""
    graph, constants = stage.graph, {}

    def at(array: str, row: int) -> str:
        return f"{array}[U({row * lanes})+e]"

    def constant(x: float) -> str:
        return constants.setdefault(repr(float(x)), f"c{len(constants)}")

    def operand(a) -> str:
        return f"t{a}" if isinstance(a, int) else constant(a)

    rows = [(array, i, row) for array, names in stage.inputs.items() for i, row in enumerate(names)]
    varying = {f"{array}.{row}": at(array, i) for array, i, row in rows if array not in stage.uniform}
    same = {f"{array}.{row}": f"{array}[{i}]" for array, i, row in rows if array in stage.uniform}
    before, body = [], []
    for i in graph.needed(stage.values.values()):
        op, args = graph.nodes[i]
        if op == "input" and args[0] in same:
            before.append(f"t{i} = {same[args[0]]}")
        else:
            body.append(f"t{i} = " + (varying[args[0]] if op == "input" else _FORMAT[op].format(*map(operand, args))))
    for array, names in stage.outputs.items():
        for i, row in enumerate(names):
            value = stage.values[array, row]
            body.append(f"{at(array, i)} = {operand(value.index) if isinstance(value, Var) else constant(value)}")
    lines = [f"def {stage.name}({', '.join([*stage.inputs, *stage.outputs])}):"]
    lines += [f"    {name} = real({text})" for text, name in constants.items()]
    lines += [f"    {line}" for line in before]
    lines += [f"    for i in range({lanes}):", "        e = U(i)", *(f"        {line}" for line in body)]
    return "\n".join(lines) + "\n"
