"""An open-loop gait through the leg law on HAMR-full, on three surfaces at once: speed in body lengths per second."""

import numpy as np

from hamr_description.names import JOINTS
from hamr_description.numbers import value
from hamr_description.rates import TARGET_HZ
from hamr_dynamics.batch import BatchSim

SURFACES = {name: value(f"contact.friction_{name}") for name in ("ptfe", "card", "sandpaper")}
STRIDE_HZ, SECONDS = 10.0, 1.0
#: Trot: diagonal legs in phase; the foot swings forward while it is up.
PHASE = {"fl": 0.0, "rr": 0.0, "fr": np.pi, "rl": np.pi}

robots = BatchSim("full", len(SURFACES), friction=np.array(list(SURFACES.values())))
for k in range(round(SECONDS * TARGET_HZ)):
    turn = 2 * np.pi * STRIDE_HZ * k / TARGET_HZ
    targets = np.zeros((robots.n, 8))
    for j, joint in enumerate(JOINTS):
        leg, axis = joint.split("_")
        side = 1.0 if leg.endswith("l") else -1.0  # angles turn about +x and +z on both sides
        angle = turn + PHASE[leg]
        targets[:, j] = side * 0.25 * (np.cos(angle) if axis == "swing" else 0.6 * np.sin(angle))
    robots.step_targets(targets)
for name, speed in zip(SURFACES, robots.position[:, 0] / value("robot.body_length") / SECONDS, strict=True):
    print(f"{name}: {speed:+.2f} body lengths per second")
