"""Where episodes start: about standing, each a little different."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hamr_description.names import LEGS, MIRROR
from hamr_description.numbers import leg_value
from hamr_description.posture import neutral_foot
from hamr_description.units import quaternion_from_ros, rate_from_si
from hamr_dynamics.batch import BatchSim

#: Standard deviations about standing at rest.
ANGLE = 0.05  # rad, each hip
RATE = 2.0  # rad/s, each hip
TILT = 0.02  # rad, roll and pitch
VELOCITY = 0.01  # m/s, each axis of the base
TURN = 0.5  # rad/s, each axis of the base
DROP = 0.1  # mm, the lowest foot starts between 0 and this height

HIPS = np.array([leg_value(leg, "hip") * (*MIRROR[leg], 1) for leg in LEGS])  # (4, 3) mm
REACH = np.array([neutral_foot(leg) for leg in LEGS]) - HIPS  # (4, 3) mm, hip to foot at rest


def feet(angles: np.ndarray) -> np.ndarray:
    """Feet (n, 4, 3) mm in base_link for hip angles (n, 8) rad: hip + Rx(lift) Rz(swing) reach (docs/architecture.md)."""
    swing, lift = angles[:, 0::2], angles[:, 1::2]
    x = np.cos(swing) * REACH[:, 0] - np.sin(swing) * REACH[:, 1]
    y = np.sin(swing) * REACH[:, 0] + np.cos(swing) * REACH[:, 1]
    z = REACH[:, 2]
    return HIPS + np.stack([x, np.cos(lift) * y - np.sin(lift) * z, np.sin(lift) * y + np.cos(lift) * z], axis=-1)


def stand_about(sim: BatchSim, mask: np.ndarray, rng: np.random.Generator) -> None:
    """Put the robots of an (n,) mask at random near standing, at x = y = yaw = 0."""
    n = int(mask.sum())
    angles = rng.normal(0.0, ANGLE, (n, 8))
    turns = Rotation.from_euler("xy", rng.normal(0.0, TILT, (n, 2)))
    lowest = np.einsum("nj,nfj->nf", turns.as_matrix()[:, 2], feet(angles)).min(axis=1)
    height = rng.uniform(0.0, DROP, n) - lowest
    sim.set_state(
        q=angles,
        qd=rate_from_si(rng.normal(0.0, RATE, (n, 8))),
        position=np.column_stack([np.zeros((n, 2)), height]),
        quaternion=quaternion_from_ros(turns.as_quat()),
        velocity=rng.normal(0.0, VELOCITY, (n, 3)),
        angular_velocity=rate_from_si(rng.normal(0.0, TURN, (n, 3))),
        mask=mask,
    )
