"""A tracer: runs plain Python functions of scalars and records straight-line code.

`Var` overloads arithmetic. Equal expressions are recorded once (hash-consing), constants are folded, and what no output
needs is dropped. The recorded `Graph` is what `emit` turns into compiled kernels and `adjoint` into their derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

COMMUTATIVE = {"add", "mul", "max", "min"}

_FOLD = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "max": max,
    "min": min,
    "neg": lambda a: -a,
    "sqrt": math.sqrt,
    "positive": lambda a: 1.0 if a > 0 else 0.0,
    "floor": math.floor,
}


class Graph:
    """Nodes in order of recording; node i is (op, args), an argument is a node index or a float."""

    def __init__(self) -> None:
        self.nodes: list[tuple[str, tuple]] = []
        self._known: dict[tuple, int] = {}

    def input(self, name: str) -> Var:
        """An input scalar; the same name gives the same node."""
        return Var(self, self._node("input", (name,)))

    def _node(self, op: str, args: tuple) -> int:
        key = (op, *args)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = len(self.nodes)
            self.nodes.append((op, args))
        return found

    def record(self, op: str, *operands: Var | float) -> Var | float:
        """The value of an operation, simplified where a constant makes it trivial."""
        args = tuple(x.index if isinstance(x, Var) else float(x) for x in operands)
        if all(isinstance(a, float) for a in args):
            return _FOLD[op](*args)
        simple = self._simplify(op, args)
        if simple is not None:
            return Var(self, simple) if isinstance(simple, int) else simple
        if op in COMMUTATIVE and len(args) == 2:
            args = tuple(sorted(args, key=lambda a: (isinstance(a, float), a)))
        return Var(self, self._node(op, args))

    def _simplify(self, op: str, args: tuple) -> int | float | None:
        a, b = (*args, None)[:2]
        if op == "neg" and self.nodes[a][0] == "neg":
            return self.nodes[a][1][0]
        if op in ("add", "mul") and isinstance(a, float):
            a, b = b, a
        if not isinstance(b, float):
            if op == "add":
                for x, y in ((a, b), (b, a)):
                    if self.nodes[y][0] == "neg":
                        return self._again("sub", x, self.nodes[y][1][0])
            if op == "sub" and isinstance(a, float) and a == 0.0:
                return self._again("neg", b)
            if op == "sub" and isinstance(b, int) and self.nodes[b][0] == "neg":
                return self._again("add", a, self.nodes[b][1][0])
            if op == "sub" and a == b:
                return 0.0
            if op == "div" and isinstance(a, float) and a == 0.0:
                return 0.0
            return None
        if op in ("add", "sub") and b == 0.0:
            return a
        if op == "mul":
            if b == 0.0:
                return 0.0
            if b == 1.0:
                return a
            if b == -1.0:
                return self._again("neg", a)
        if op == "div":
            return self._again("mul", a, 1.0 / b)
        return None

    def _again(self, op: str, *args: int | float) -> int | float:
        result = self.record(op, *(Var(self, a) if isinstance(a, int) else a for a in args))
        return result.index if isinstance(result, Var) else result

    def needed(self, outputs: Iterable[Var | float]) -> list[int]:
        """Indices of the nodes that the outputs depend on; each comes just before its first use, so that few values are alive at a time."""
        order: dict[int, None] = {}
        stack = [o.index for o in reversed(list(outputs)) if isinstance(o, Var)]
        while stack:
            i = stack[-1]
            op, args = self.nodes[i]
            waiting = [a for a in args if isinstance(a, int) and a not in order] if op != "input" and i not in order else []
            if waiting:
                stack.extend(reversed(waiting))
            else:
                order[stack.pop()] = None
        return list(order)


class Var:
    """A scalar being traced."""

    __slots__ = ("graph", "index")

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    def __add__(self, other):
        return self.graph.record("add", self, other)

    def __sub__(self, other):
        return self.graph.record("sub", self, other)

    def __rsub__(self, other):
        return self.graph.record("sub", other, self)

    def __mul__(self, other):
        return self.graph.record("mul", self, other)

    def __truediv__(self, other):
        return self.graph.record("div", self, other)

    def __rtruediv__(self, other):
        return self.graph.record("div", other, self)

    def __neg__(self):
        return self.graph.record("neg", self)

    def __pow__(self, power: int):
        if not isinstance(power, int) or power < 1:
            raise TypeError(f"a traced scalar can be raised to whole powers from 1, not {power}")
        return self if power == 1 else self * self ** (power - 1)

    def __abs__(self):
        return self.graph.record("max", self, -self)

    __radd__ = __add__
    __rmul__ = __mul__

    def __bool__(self):
        raise TypeError("a traced scalar has no truth value: use scalar.where or scalar.maximum instead of if")
