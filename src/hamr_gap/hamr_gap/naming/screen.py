"""All effects at all places in one linear picture: what each adds to the readings, after everything that a re-tune can do.

From a fitted model, each size of each form at each place (and each of a few shapes) is switched on alone in a lane. The products
of these responses with each other and with the residual are enough to solve for any set of effects: all pairs are a second's work.
What looks best is then simulated, for the linear picture deceives where a re-tune moves a resonance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from hamr_dynamics.effects.law import Parameter

from ..fitting.fit import Fit
from ..fitting.linear import jacobian
from ..fitting.parameters import Candidate
from ..fitting.threads import at_once
from ..fitting.weighed import Weighed

BATCH = 48  # lanes at a time
NEAR = 2.0  # times as large or small a response as wanted, that serves as well
RESIZED = 3  # times that a size is changed for it: what a machine does in the end grows less than what slows it down
ROUNDING = 1e-6  # of the largest response of a size with a threshold: what does no more does nothing
DIVERGED = 1e9  # in units of the noise: as which larger responses count


@dataclass(frozen=True, slots=True)
class Column:
    """A size switched on at one place, with the shapes it was screened with: rows -> values in scales."""

    row: str
    parameter: Parameter
    size: float
    shapes: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Solution:
    """Linear least squares with some columns: coefficients of the fixed ones and of these (in units of their size), half sum of squares."""

    chosen: tuple[int, ...]
    value: np.ndarray
    cost: float


@dataclass
class Screen:
    """Linear picture about a fit.

    Attributes:
        columns: of the effects; the first `fixed` of the products belong to what the fit had free, and the sensors.
        groups: (effect, form, place) -> one tuple of columns for each set of shapes.
        fitted: products (G, b, r r) on the fitted readings.
        ridge: (K,) prior precision of each column. amplitude: rms of the responses wanted, in units of the noise.
    """

    columns: list[Column]
    fixed: int
    groups: dict[tuple[str, str, int], list[tuple[int, ...]]]
    fitted: tuple
    ridge: np.ndarray
    amplitude: float

    def options(self, candidate: Candidate) -> list[tuple[int, ...]]:
        """Sets of columns of a candidate: one for each set of shapes."""
        found = [self.groups.get((candidate.effect, candidate.form, place), []) for place in candidate.places]
        return [tuple(c for part in parts for c in part) for parts in zip(*found, strict=True)]

    def solve(self, chosen: Sequence[int]) -> Solution:
        """Least squares on the fitted readings over all that is fixed and the chosen columns, none beyond its bounds."""
        gram, product_, square = self.fitted
        index = [*range(self.fixed), *(self.fixed + c for c in chosen)]
        low = np.array([-np.inf] * self.fixed + [self.columns[c].parameter.low / self.columns[c].size for c in chosen])
        high = np.array([np.inf] * self.fixed + [self.columns[c].parameter.high / self.columns[c].size for c in chosen])
        matrix = gram[np.ix_(index, index)] + np.diag(self.ridge[index])
        scale = 1.0 / np.sqrt(np.diag(matrix))
        matrix, right = matrix * scale[:, None] * scale + 1e-10 * np.eye(len(index)), product_[index] * scale
        held, x = np.zeros(len(index), bool), np.zeros(len(index))
        for _ in range(len(chosen) + 1):
            free = ~held
            x[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free] - matrix[np.ix_(free, held)] @ x[held])
            value = x * scale
            beyond = free & ((value < low - 1e-12) | (value > high + 1e-12))
            if not beyond.any():
                break
            x[beyond] = np.where(value < low, low, high)[beyond] / scale[beyond]
            held |= beyond
        return Solution(tuple(chosen), x * scale, 0.5 * float(square - 2.0 * x @ right + x @ matrix @ x))

    def size_of(self, k: int, share: float) -> float:
        """Size at which column k responds with a share of what it was seen with.

        One with a threshold does nothing before that is met, and then about as much as it is beyond: between the sizes that were seen
        the rms of the responses, as far as it grows, says where. The threshold is where the line through the first two meets zero.
        """
        column = self.columns[k]
        if not column.parameter.screen:
            return share * column.size
        own = [j for j, c in enumerate(self.columns) if (c.row, c.shapes) == (column.row, column.shapes)]
        sizes, rms = np.array([self.columns[j].size for j in own]), np.sqrt(np.diag(self.fitted[0])[self.fixed + np.array(own)])
        last = own.index(k)
        first = min(int(np.argmax(rms > ROUNDING * rms.max())), last)
        met = 0.0 if first == 0 else sizes[first - 1]
        if first + 1 < len(own) and rms[first + 1] > rms[first]:
            met = max(met, sizes[first] - rms[first] * (sizes[first + 1] - sizes[first]) / (rms[first + 1] - rms[first]))
        below, above = np.minimum.accumulate(rms[first : last + 1][::-1])[::-1], np.maximum.accumulate(rms[last:])[1:]
        return float(np.interp(share * rms[last], [0.0, *below, *above], [met, *sizes[first:]]))

    def best(self, candidate: Candidate, count: int = 1) -> list[Solution]:
        """The shapes with which a candidate alone explains most of the fitted readings."""
        return sorted((self.solve(option) for option in self.options(candidate)), key=lambda s: s.cost)[:count]


def screen(weighed: Weighed, base: Fit, candidates: Sequence[Candidate], *, amplitude: float, before: Screen | None = None) -> Screen:
    """The linear picture of all candidates about a fit.

    Args:
        amplitude: rms of the responses wanted, in units of the noise: about that of what is to be explained, so that laws with a
            threshold are seen at the size they must have.
        before: a picture of the same machine, whose sizes are near those wanted.
    """
    weighed = weighed.fitted
    model, scales, until = weighed.coarse or weighed.model, weighed.model.scales, weighed.until
    plain = model.runs(base.free, base.x, until)[0]
    columns, groups = _columns(candidates, scales)
    sizes = {(c.row, c.shapes): _resized(c, amplitude / before.amplitude) for c in before.columns} if before else {}
    columns = [c if c.parameter.screen else sizes.get((c.row, c.shapes), c) for c in columns]
    home = model.rows(base.free, base.x)[0]
    index = {name: i for i, name in enumerate(model.machine.parameter_rows)}
    chosen = weighed.chosen[:until]

    def rows_of(part: Sequence[Column]) -> np.ndarray:
        rows = np.tile(home, (len(part), 1))
        for k, column in enumerate(part):
            for row, x in column.shapes:
                rows[k, index[row]] = x * scale_of(row)
            rows[k, index[column.row]] = home[index[column.row]] + column.size * scale_of(column.row)
        return rows

    dimension = {c.row: c.parameter.dimension for c in columns}
    for candidate in candidates:
        dimension |= {row: p.dimension for shape in (False, True) for row, p in candidate.rows(shape=shape)}

    def scale_of(row: str) -> float:
        return scales.of(dimension[row])

    def respond(part: Sequence[Column]) -> np.ndarray:
        with np.errstate(over="ignore"):  # a run that diverges is not finite, and left out
            y = model.run_rows(rows_of(part), until) - plain
            read = base.sensors.read(y, model.reading_step, model.starts) - base.sensors.bias
            return (weighed.beside(read) / weighed.sigma).astype(np.float32)

    responses = np.empty((len(columns), *plain.shape), np.float32)

    def simulate(which: np.ndarray) -> None:
        parts = [which[at : at + BATCH] for at in range(0, len(which), BATCH)]
        for part, found in zip(parts, at_once(lambda part: respond([columns[k] for k in part]), parts), strict=True):
            responses[part] = found

    simulate(np.arange(len(columns)))  # at the typical size, or another picture's, then at the size that matters
    for _ in range(RESIZED):
        responses[_diverged(responses)] = DIVERGED
        rms = np.sqrt(np.mean(np.square(responses[:, chosen]), axis=1))
        before, columns = columns, [_resized(c, amplitude / max(r, 1e-9)) for c, r in zip(columns, rms, strict=True)]
        simulate(np.array([k for k, (c, old) in enumerate(zip(columns, before, strict=True)) if c is not old], int))
    responses[_diverged(responses)] = 0.0

    everything = replace(weighed, model=model, chosen=np.ones_like(chosen))
    fixed = jacobian(everything, base.free, base.x, plain, base.sensors).T.reshape(-1, *plain.shape)
    every = np.concatenate([fixed, responses])
    a, r = every[:, chosen].astype(float), weighed.left(base.reading[:until])[chosen]
    ridge = weighed.doubt(r) * np.concatenate([
        [f.sd**-2.0 for f in base.free], weighed.sensor_precision, [(c.size / (30.0 * c.parameter.typical)) ** 2 for c in columns]
    ])  # fmt: skip
    return Screen(columns, len(fixed), groups, (a @ a.T, a @ r, float(r @ r)), ridge, amplitude)


def _diverged(responses: np.ndarray) -> np.ndarray:
    """(K,) which of (K, n, channels) responses are too large, or not finite."""
    return ~(np.maximum(responses.max((1, 2)), -responses.min((1, 2))) < DIVERGED)


def _columns(candidates: Sequence[Candidate], scales) -> tuple[list[Column], dict]:
    columns, groups = [], {}
    for candidate in candidates:
        for place in candidate.places:
            key = (candidate.effect, candidate.form, place)
            if key in groups:
                continue
            law, groups[key], known = candidate.law, [], {}
            for shapes in product(*(s.screen or (s.typical,) for s in law.shapes)):
                pinned = [(s.name, (candidate.row(s, place), x)) for s, x in zip(law.shapes, shapes, strict=True)]
                for sizes in zip(*(p.screen or (p.typical,) for p in law.sizes), strict=True):
                    own = [tuple(pin for name, pin in pinned if p.by is None or name in p.by) for p in law.sizes]
                    wanted = [Column(candidate.row(p, place), p, x, pins) for p, x, pins in zip(law.sizes, sizes, own, strict=True)]
                    groups[key].append(tuple(known.setdefault(column, len(columns) + len(known)) for column in wanted))
            columns += known
    return columns, groups


def _resized(column: Column, factor: float) -> Column:
    """A column at another size, within bounds and reason; itself if that is near, or has screening values of its own."""
    if column.parameter.screen or 1.0 / NEAR < factor < NEAR:
        return column
    p = column.parameter
    limit = 0.5 * (p.high if column.size > 0 else -p.low)
    size = abs(p.typical) * np.clip(factor * abs(column.size / p.typical), 1e-3, 1e3)
    size = float(np.copysign(min(size, abs(limit)), column.size))
    return Column(column.row, p, size, column.shapes)
