"""Many robots at once: how a hip answers a 10 degree step of its target on HAMR-full, with and without the inner 20 kHz loop."""

import numpy as np

from hamr_description.names import JOINTS, torque_sign
from hamr_description.numbers import value
from hamr_description.rates import SUBSTEPS
from hamr_dynamics.batch import BatchSim

TARGET = np.zeros((1, 8))
TARGET[0, JOINTS.index("fl_swing")] = np.radians(10.0)

inside = BatchSim("full", 1, environment="suspended")
run = inside.step_targets(TARGET, steps=5 * SUBSTEPS, record=True)  # the leg law at 20 kHz, for 20 ms
print(f"leg law at 20 kHz: fl_swing is at {np.degrees(run['q'][0, -1, 0]):.2f} degrees after 20 ms")

outside = BatchSim("full", 1, environment="suspended")
signs = np.array([torque_sign(joint) for joint in JOINTS])
for _ in range(25):  # the same law at 250 Hz: each voltage is held for 4 ms
    drive = value("controller.kp") * (TARGET - outside.q) - value("controller.kd") * outside.qd
    volts = np.clip(value("actuator.neutral_voltage") + signs * drive, 0.0, value("actuator.bias_voltage"))
    run = outside.step_voltages(np.repeat(volts[:, None], SUBSTEPS, axis=1), record=True)
swing = np.degrees(run["q"][0, :, 0])
print(f"the same law at 250 Hz: still between {swing.min():.1f} and {swing.max():.1f} degrees after 100 ms")
