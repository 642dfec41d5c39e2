"""A machine of one's own from a table: what slows down a pendulum that swings to rest, with viscous friction as the only guess.

The table is simulated here, in small steps that know nothing of the library, with dry friction and air drag that `arm` lacks: where
yours is measured, only `arm` and the path of the table are needed. docs/other_machines.md tells more.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from hamr_dynamics.machine import Machine, Terms
from hamr_dynamics.scalar import cos, sin
from hamr_gap.plants import run
from hamr_gap.showing.words import sentences

COLUMNS = {"drive": 0.0}  # nothing drives it


def arm() -> Machine:
    """Inertia some 10 % off, friction a guess; kg m^2, N m, N m s."""
    inertia, weight, damping = 0.0036, 0.21, 0.0003

    def terms(q, v_mid, v, u) -> Terms:
        force = u[0] - weight * sin(q[0]) - damping * v[0]
        return Terms((inertia,), (0.0,), (force,), (weight * cos(q[0]),), (damping,), (u[0],))

    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "N*m"}
    return Machine("arm", ("arm",), ("arm",), terms, lambda q, slip: (q[0],), units, dict.fromkeys("FQTU", 1.0))


def table(path: Path, seconds: float = 30.0, count: float = 2.0 * math.pi / 40_000) -> Path:
    """What an encoder says of a release from 1.6 rad, every millisecond."""
    angle, rate, seen = 1.6, 0.0, []
    for _ in range(int(seconds * 1000)):
        seen.append(angle)
        for _ in range(20):
            rate -= 5e-5 * (64.0 * math.sin(angle) + 0.02 * rate + 0.2 * math.tanh(rate / 2e-3) + 0.0056 * rate * abs(rate))
            angle += 5e-5 * rate
    read = np.round(np.array(seen) / count) * count
    np.savetxt(path, np.column_stack([np.arange(len(read)) / 1000, read]), delimiter=",", header="time [s],arm [rad]", comments="")
    return path


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        verdict = run(f"{__file__}:arm", [table(Path(folder, "swing.csv"))], Path(folder, "out"))
    print("\n".join(sentences(verdict)))
