"""The feet's contact in MuJoCo as the spring and damper of numbers.yaml with Coulomb friction: the kernels' law, in MuJoCo's terms.

MuJoCo's contact is a constraint. As hard as it comes, it is no Coulomb friction: its convex cone couples sliding with lifting, so that
a foot that slides at v is pushed up at mu v and hops (a sliding robot by 0.3 mm), and walking on smooth ground suffers. What
makes it a spring and damper is a regulariser R far above the foot's own inverse inertia A,

    (A + R) f = -B v - K imp r - a0   ->   f = -(K imp / R) r - (B / R) v,   R = (1 - imp) / imp * A0

with A0 MuJoCo's estimate of A. Sideways R is divided by impratio and stays far below A: friction is hard, and B = 1 / timestep
makes it oppose the foot's next velocity.
"""

from __future__ import annotations

import mujoco
import numpy as np

from hamr_description.numbers import value

IMPEDANCE = 1e-3  # share of the constraint in the normal direction
IMPRATIO = 1e5


def set_contact(model: mujoco.MjModel) -> None:
    """Sets every contact pair of a model; its friction coefficients stay."""
    model.opt.impratio = IMPRATIO
    for pair in range(model.npair):
        bodies = model.geom_bodyid[[model.pair_geom1[pair], model.pair_geom2[pair]]]
        regulariser = (1.0 - IMPEDANCE) / IMPEDANCE * np.sum(model.body_invweight0[bodies, 0])
        model.pair_solimp[pair, :2] = IMPEDANCE
        # negative numbers are stiffness and damping themselves; MuJoCo divides them by the impedance, the stiffness twice
        model.pair_solref[pair] = -IMPEDANCE * regulariser * np.array([value("contact.stiffness"), value("contact.damping")])
        model.pair_solreffriction[pair] = 0.0, -IMPEDANCE / model.opt.timestep
