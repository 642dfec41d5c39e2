"""How strong an effect must be to be named: a logistic curve over strength, seconds of data and noise, from cases that were solved.

    hamr gap bench --set report --singles 54 --strength 1 --out out/gap_weak                 and other strengths, in folders of their own
    python -m hamr_gap.bench.power out/gap_bench/verdicts.csv out/gap_weak/verdicts.csv      the map

Families share the slopes and differ in where their curve lies; a weak prior holds what few cases leave open. So a family that was
never missed has a bound rather than a figure.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from scipy.optimize import minimize
from scipy.special import expit, logit

from hamr_description.errors import ConfigError, HamrError

from . import listing, power_plot

WANTED = 0.9  # probability of the right name at the right place
USUAL_S, USUAL_NOISE = 12.0, 3e-3  # of a run, and share of the stroke
SPREAD = 1.5  # standard deviation of families' curves, in log odds, that is believed beforehand
SLOPES = 3.0  # the same of slopes


@dataclass(frozen=True)
class Power:
    """Log odds of the right name: own[family] + strength ln(x) + seconds ln(s / 12) + noise ln(n / 0.003).

    Attributes:
        families. values: (families + 4,) of families' differences from their mean, that mean, and the three slopes. covariance: of these.
    """

    families: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray

    def needed(self, family: str, seconds: float = USUAL_S, noise: float = USUAL_NOISE) -> tuple[float, float, float]:
        """Strength in floors that is named with probability `WANTED`, and its 95 % interval."""
        row = _row(self.families, family, 1.0, seconds, noise)
        slope = len(self.families) + 1
        at = row @ self.values
        log = (logit(WANTED) - at) / self.values[slope]
        gradient = -row / self.values[slope]
        gradient[slope] -= log / self.values[slope]
        spread = 1.96 * float(np.sqrt(gradient @ self.covariance @ gradient))
        return float(np.exp(log)), float(np.exp(log - spread)), float(np.exp(log + spread))

    def probability(self, family: str, strength: float, seconds: float = USUAL_S, noise: float = USUAL_NOISE) -> float:
        """Of the right name, at a strength in floors."""
        return float(expit(_row(self.families, family, strength, seconds, noise) @ self.values))

    def said(self, family: str, seconds: float, tried: tuple[float, float]) -> str:
        """What is needed, as text: no figure beyond the weakest and strongest effects that were tried."""
        weak, strong = tried
        if self.probability(family, weak, seconds) >= WANTED:
            return f"< {weak:.2g}"
        if self.probability(family, strong, seconds) < WANTED:
            return f"> {strong:.2g}"
        found, low, high = self.needed(family, seconds)
        return f"{found:.2g} ({max(low, weak):.2g}..{min(high, strong):.2g})"


def power(cases: Sequence[tuple[str, float, float, float, bool]]) -> Power:
    """The curve of (family, strength in floors, seconds, noise as a share of the stroke, whether named rightly)."""
    families = tuple(sorted({family for family, *_ in cases}))
    rows = np.array([_row(families, *case[:4]) for case in cases])
    sign = np.array([1.0 if case[4] else -1.0 for case in cases])
    center = np.array([0.0] * len(families) + [0.0, 1.0, 0.0, 0.0])
    precision = np.array([SPREAD**-2.0] * len(families) + [SLOPES**-2.0] * 4)

    def cost(x: np.ndarray) -> tuple[float, np.ndarray]:
        odds = sign * (rows @ x)
        off = x - center
        return float(np.logaddexp(0.0, -odds).sum() + 0.5 * precision @ off**2), -rows.T @ (sign * expit(-odds)) + precision * off

    found = minimize(cost, center, jac=True, method="BFGS").x
    p = expit(rows @ found)
    return Power(families, found, np.linalg.inv((rows * (p * (1.0 - p))[:, None]).T @ rows + np.diag(precision)))


def _row(families: Sequence[str], family: str, strength: float, seconds: float, noise: float) -> np.ndarray:
    slopes = [1.0, np.log(strength), np.log(seconds / USUAL_S), np.log(noise / USUAL_NOISE)]
    return np.array([*(1.0 if family == other else 0.0 for other in families), *slopes])


def outcomes(listings: Sequence[Path]) -> list[tuple[str, float, float, float, bool]]:
    """What `power` needs, of the single effects in listings of the benchmark."""
    lines = [line for path in listings for line in listing.read(path, listing.COLUMNS) if line["group"] == "single"]
    if not lines:
        raise ConfigError("No solved case with a single effect is in these listings; make some with: hamr gap bench --singles 54")
    numbers = ([float(line[column]) for column in listing.DATA] for line in lines)
    return [(line["hidden"].split(" (")[0], *of, line["right"] == "1") for line, of in zip(lines, numbers, strict=True)]


def main(listings: tyro.conf.Positional[tuple[Path, ...]], picture: Path | None = None) -> None:
    """Prints the map: strengths in floors, for each length of record that was tried.

    Args:
        listings: files that `hamr gap bench` wrote. picture: file for the same as a picture, with every case.
    """
    cases = outcomes(listings)
    found = power(cases)
    lengths = sorted({seconds for _, _, seconds, _, _ in cases})
    strengths = [strength for _, strength, *_ in cases]
    tried = min(strengths), max(strengths)
    say = sys.stdout.write
    say("| effect | right | " + " | ".join(f"{s:g} s" for s in lengths) + " |\n" + "|---" * (len(lengths) + 2) + "|\n")
    for family in found.families:
        own = [right for name, *_, right in cases if name == family]
        cells = (found.said(family, s, tried) for s in lengths)
        say(f"| `{family}` | {sum(own)} of {len(own)} | " + " | ".join(cells) + " |\n")
    for name, x, sd in zip(("strength", "seconds", "noise"), found.values[-3:], np.sqrt(np.diag(found.covariance))[-3:], strict=True):
        say(f"\nlog odds per factor e in {name}: {x:.2f} +- {sd:.2f}")
    say("\n")
    if picture:
        power_plot.drawn(cases, found.needed, lengths).savefig(picture)


if __name__ == "__main__":
    try:
        tyro.cli(main)
    except HamrError as error:
        sys.exit(str(error))
