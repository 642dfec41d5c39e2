"""Turns a traced graph into the source of a compiled loop over lanes.

Each array is flat: row r of lane e lies at r * L + e with L a literal, so that the loop over lanes has a straight-line body
on unit strides and LLVM makes vectors of it. Values are computed just before they are used and stored as soon as they are
known: what does not fit the registers goes through memory, and that costs more than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import indent

from .trace import Graph, Var

#: Operation -> its source text; all are those of `straight`.
OPERATIONS = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{} * {}",
    "div": "{} / {}",
    "neg": "-{}",
    "sqrt": "sqrt({})",
    "max": "larger({}, {})",
    "min": "smaller({}, {})",
    "floor": "floor({})",
    "positive": "gate({})",
}


def rows(**sizes: int) -> tuple[str, ...]:
    """Row names: rows(q=2, h=1) -> q.0 q.1 h."""
    return tuple(f"{name}.{i}" if n > 1 else name for name, n in sizes.items() for i in range(n))


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


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a step.

    Attributes:
        stage: traced.
        sizes: indices of the parameter rows that are zero when the part does nothing; none for a part that always runs.
        memory: row of `state` at which its internal states begin.
        own: how the names of rows begin that no other part uses.
    """

    stage: Stage
    sizes: tuple[int, ...] = ()
    memory: int = 0
    own: str = ""


def parts_source(
    parts: Sequence[tuple[Part, int]], *, laws: Sequence[Part], work: Mapping[str, int], flag: str, depth: int
) -> tuple[str, str]:  # fmt: skip
    """Source of parts, each with its lanes, as functions of `work`, and of their calls in order, `depth` deep.

    Args:
        laws: parts that only some robots use; the k-th is called where `flag` of k is set.
    """
    functions, calls = "", ""
    for part, lanes in parts:
        name, own, call = part.stage.name, work, f"{part.stage.name}(work)\n"
        if part.sizes:
            own = {**work, "memory": work["state"] + part.memory * lanes}
            call = f"if {flag.format(laws.index(part))}:\n    {call}"
        functions += _function(name, "work", loop_body(part.stage, lanes, work=own))
        calls += call
    return functions, indent(calls, " " * depth).rstrip()


def loop_source(stage: Stage, lanes: int) -> str:
    """Source of NAME(inputs..., outputs...), for compiled code: the stage over all lanes, each array an argument."""
    return _function(stage.name, ", ".join([*stage.inputs, *stage.outputs]), loop_body(stage, lanes))


def _function(name: str, arrays: str, body: str) -> str:
    return f'\n{name} = over_lanes("{arrays}", """\n{body}""")\n'


def loop_body(stage: Stage, lanes: int, *, work: Mapping[str, int] | None = None) -> str:
    """Python source of the stage over all lanes, as `straight.over_lanes` takes it.

    Args:
        work: array -> where its first row begins in one flat array `work` that holds them all; without it, arrays go by their own
            names. In one array the compiler knows what overlaps; with several it tests at run time every pair of rows, which can
            cost more than the stage. In `work`, outputs may lie on inputs.
    """
    graph, constants = stage.graph, {}

    def at(array: str, row: int) -> str:
        lane = "" if array in stage.uniform else "+e"
        place = row if array in stage.uniform else row * lanes
        return f"{array}[U({place}){lane}]" if work is None else f"work[U({work[array] + place}){lane}]"

    def name(a) -> str:
        return f"x{a}" if isinstance(a, int) else constants.setdefault(repr(float(a)), f"c{len(constants)}")

    sources = {f"{array}.{row}": at(array, i) for array, names in stage.inputs.items() for i, row in enumerate(names)}
    read = set(sources.values())
    before, body, last = [], [], []
    stores: dict[int, list[str]] = {}
    stays = set()
    for array, names in stage.outputs.items():
        for i, row in enumerate(names):
            value = stage.values[array, row]
            if not isinstance(value, Var):
                last.append(f"{at(array, i)} = {name(float(value))}")
            elif sources.get(graph.nodes[value.index][1][0]) == at(array, i):
                stays.add((array, row))  # an input that lies there already
            else:
                stores.setdefault(value.index, []).append(at(array, i))
    for i in graph.needed(value for key, value in stage.values.items() if key not in stays):
        op, args = graph.nodes[i]
        once = op == "input" and args[0].split(".")[0] in stage.uniform
        text = sources[args[0]] if op == "input" else OPERATIONS[op].format(*map(name, args))
        (before if once else body).append(f"{name(i)} = {text}")
        for place in stores.get(i, ()):  # at once, so that the value need not be kept; but what is still to be read is not overwritten
            (last if place in read else body).append(f"{place} = {name(i)}")
    before += [f"{name} = real({text})" for text, name in constants.items()]
    lines = [*before, f"for i in range({lanes}):", "    e = U(i)", *(f"    {line}" for line in body + last)]
    return "".join(f"{line}\n" for line in lines)
