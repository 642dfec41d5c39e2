"""The series law: drive and rate terms, each times a polynomial of the hip angles.

Any leg of rigid links, springs, dampers and linear drives obeys, in its two hip angles q, a torque balance that is affine in
the drive voltages V, linear in the rates through the dampers, and quadratic in the rates through the moving inertia; what
multiplies these terms depends on q alone. The law states just that and leaves the eight dependences on q open:

    torque_i = sum_j c_ij(q) phi_j,   phi = (1, V_swing, V_lift, v_swing, v_lift, v_swing^2, v_swing v_lift, v_lift^2)

It is linear in its weights, so that fitting torques is one linear least-squares problem with one solution; and what it learns
of V and v at one amplitude holds at every other. Angles and rates are clipped to written limits: the torque is bounded, and a
bounded torque on a damped leg with stops cannot make it diverge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import emit, layout, scalar
from hamr_dynamics.emit import Stage, loop_source

TERMS = 8
RATE = 0.1  # rad/ms: unit of the rates in the terms, so that weights of all terms are of like size
LIMITS = emit.rows(low=2, high=2, rate_limit=1)


@dataclass(frozen=True, slots=True)
class Series:
    """Architecture of a series law, one for all four legs.

    Attributes:
        degree: of the polynomials of the hip angles.
    """

    degree: int = 6
    kind = "series"

    @property
    def powers(self) -> list[tuple[int, int]]:
        """Powers (of swing, of lift) of each monomial."""
        return [(i, n - i) for n in range(self.degree + 1) for i in range(n + 1)]

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the weights: limits of angles and rate, then w.i with i = (output, term, monomial)."""
        return (*LIMITS, *emit.rows(w=2 * TERMS * len(self.powers)))

    def terms(self, q, v, a, drive, limits) -> tuple[tuple, list]:
        """The eight terms phi and the monomials, over any scalar.

        Args:
            q, v, a: (2,) rad, rad/ms, rad/ms^2 at the beginning of a step; the law sees angles and rates half a step ahead, as the
                step's forces do.
            drive: (2,) V from neutral. limits: low (2,), high (2,) rad and rate, rad/ms.
        """
        low, high, top = limits[0:2], limits[2:4], limits[4]
        half = 0.5 * SERVO_MS
        angle = [scalar.clip(x + half * y, lo, hi) for x, y, lo, hi in zip(q, v, low, high, strict=True)]
        unit = [(2.0 * x - (hi + lo)) / (hi - lo) for x, lo, hi in zip(angle, low, high, strict=True)]
        rate = [scalar.clip(x, -top, top) * (1.0 / RATE) for x in v]
        middle = [scalar.clip(x + half * y, -top, top) * (1.0 / RATE) for x, y in zip(v, a, strict=True)]
        volts = [x * (1.0 / value("actuator.neutral_voltage")) for x in drive]
        powers = [[1.0], [1.0]]
        for p, x in zip(powers, unit, strict=True):
            for _ in range(self.degree):
                p.append(p[-1] * x)
        monomials = [powers[0][i] * powers[1][j] for i, j in self.powers]
        return (1.0, *volts, *rate, middle[0] * middle[0], middle[0] * middle[1], middle[1] * middle[1]), monomials

    def torque(self, q, v, a, drive, weights) -> tuple:
        """(2,) hip torques, N mm, over any scalar; arguments as `terms`, weights in the order of `rows`."""
        phi, monomials = self.terms(q, v, a, drive, weights[: len(LIMITS)])
        w, n = weights[len(LIMITS) :], len(monomials)
        torque = []
        for i in (0, 1):
            total = 0.0
            for j, term in enumerate(phi):
                coefficient, start = 0.0, (i * TERMS + j) * n
                for k, monomial in enumerate(monomials):
                    coefficient = coefficient + w[start + k] * monomial
                total = total + coefficient * term
            torque.append(total)
        return tuple(torque)

    def stage(self, name: str = "network") -> Stage:
        """The traced law: (state, drive, weights, scratch) -> torque, weights the same for all lanes."""
        inputs = {"state": layout.STATE, "drive": layout.DRIVE, "weights": self.rows, "scratch": ()}
        stage = Stage(name, inputs, {"torque": emit.rows(torque=2)}, uniform=frozenset({"weights"}))
        q, v, a = (stage.reads("state", x, 2) for x in "qva")
        weights = [stage.read("weights", row) for row in self.rows]
        stage.write("torque", "torque", self.torque(q, v, a, stage.reads("drive", "drive", 2), weights))
        return stage

    def source(self, robots: int) -> str:
        """Compiled form for blocks of `robots` robots (hamr_dynamics.driver)."""
        return loop_source(self.stage(), 4 * robots)

    def scratch(self, robots: int) -> int:
        """Scratch numbers per block: none."""
        return 1

    def packed(self, values: np.ndarray) -> np.ndarray:
        """Weights in the order in which the kernel reads them: as they are."""
        return values

    def design(self, q, v, a, drive, limits) -> np.ndarray:
        """Matrix (n, TERMS * monomials) whose product with each output's weights is its torque; arguments (n, 2)."""
        phi, monomials = self.terms(q.T, v.T, a.T, drive.T, limits)
        ones = np.ones(len(q))
        return np.stack([ones * p * m for p in phi for m in monomials], axis=1)
