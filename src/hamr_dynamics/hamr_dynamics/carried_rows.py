"""Source of what goes between the arrays of a block and the working array: of laws, only what those have that some lane uses.

The bank has some five hundred rows of parameters, and a robot seldom uses more than ten.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from . import layout
from .emit import Part
from .plant import Plant

#: First places and ends of what each law has in `state` and in `param`; and (law, first, end) of the sizes among it.
TABLES = """
MEMORY = np.array({memory})
PARAMETERS = np.array({parameters})
SIZES = np.array({sizes})
"""
LOAD = """
        used[:] = False
        for law, first, end in SIZES:
            some = False
            for i in range(first, end):
                some |= param[b, U(i)] != 0
            used[law] |= some
        for law in range(used.size):
            if used[law]:
                for i in range(PARAMETERS[law, 0], PARAMETERS[law, 1]):
                    work[U({param}) + U(i)] = param[b, i]
                for i in range(MEMORY[law, 0], MEMORY[law, 1]):
                    work[U({state}) + U(i)] = state[b, i]"""
STORE = """
        for law in range(used.size):
            if used[law]:
                for i in range(MEMORY[law, 0], MEMORY[law, 1]):
                    state[b, i] = work[U({state}) + U(i)]"""


def carried_rows(plant: Plant, laws: Sequence[Part], places: Mapping[str, int], legs: int) -> dict[str, str]:
    """Source by name: "tables" of the module, "used" flags of the function, and for each block "load" and "store".

    Args:
        laws: parts that only some robots use. places: where `state` and `param` begin in the working array. legs: lanes.
    """
    rows = {"state": layout.state_rows(plant), "param": layout.parameter_rows(plant)}
    own, always = {}, {}
    for array, names in rows.items():
        own[array] = [_spans([i for i, row in enumerate(names) if row.startswith(part.own)]) for part in laws]
        taken = {i for spans in own[array] for first, end in spans for i in range(first, end)}
        spans = [(legs * first, legs * end) for first, end in _spans([i for i in range(len(names)) if i not in taken])]
        always[array] = [(f"work[{places[array] + first}:{places[array] + end}]", f"{array}[b, {first}:{end}]") for first, end in spans]
    load = "\n".join(f"        {work} = {block}" for spans in always.values() for work, block in spans)
    store = "\n".join(f"        {block} = {work}" for work, block in always["state"])
    if not laws:
        return {"tables": "", "used": "", "load": load, "store": store}
    tables = {
        "memory": [[legs * x for x in (spans or [(0, 0)])[0]] for spans in own["state"]],
        "parameters": [[legs * x for x in spans[0]] for spans in own["param"]],
        "sizes": [[k, legs * first, legs * end] for k, part in enumerate(laws) for first, end in _spans(part.sizes)],
    }
    return {
        "tables": TABLES.format(**tables), "used": f"\n    used = np.empty({len(laws)}, np.bool_)",
        "load": load + LOAD.format(**places), "store": store + STORE.format(**places),
    }  # fmt: skip


def _spans(rows: Sequence[int]) -> list[tuple[int, int]]:
    """Runs of neighbours among rows, as first row and end."""
    firsts = [row for row in rows if row - 1 not in rows]
    ends = [row + 1 for row in rows if row + 1 not in rows]
    return list(zip(firsts, ends, strict=True))
