"""One JointState per sample, for plotting tools that do not look into trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hamr_description.names import ACTUATORS, JOINTS, Topic

from .bag import open_bag
from .cdr import NS
from .frames import state_layout
from .reader import channels, load
from .topics import JOINT_STATE, LATCHED
from .writer import BagWriter

#: Topics of a flattened bag.
SAMPLES_JOINTS = f"{Topic.SERVO_JOINTS}/samples"
SAMPLES_ACTUATORS = f"{Topic.SERVO_ACTUATORS}/samples"


def flatten(bag: str | Path, out: str | Path) -> int:
    """Write the samples of a bag as sensor_msgs/JointState, one message each; returns the number of samples.

    `/servo/joints/samples` has the hip angles (position, rad) and their rates (velocity, rad/s); `/servo/actuators/samples`
    the tip deflections (position, m), their rates (velocity, m/s) and the drive voltages (effort, V!). What the bag does
    not have stays empty. Latched topics are copied. BagError as of `load`, or if `out` exists.
    """
    recording = load(bag, measured=[name for name in channels(bag) if name in ("deflections", "rates", "deflection_rates")])
    times = np.round(recording.time * NS).astype(np.int64)
    joints = _states(JOINTS, times, position=recording.angles, velocity=recording.rates)
    actuators = _states(
        ACTUATORS, times, position=recording.deflections, velocity=recording.deflection_rates, effort=recording.voltages
    )  # fmt: skip
    with open_bag(bag) as opened, BagWriter(out) as writer:
        for message in opened.messages(LATCHED):
            writer.write(message.topic, message.raw, int(times[0]))
        for joint_state, actuator_state, stamp in zip(joints, actuators, times.tolist(), strict=True):
            writer.write(SAMPLES_JOINTS, joint_state, stamp, JOINT_STATE)
            writer.write(SAMPLES_ACTUATORS, actuator_state, stamp, JOINT_STATE)
    return len(times)


def _states(names: tuple[str, ...], times: np.ndarray, **fields: np.ndarray | None) -> list[bytes]:
    """One message per row, laid out all at once."""
    present = {name: array for name, array in fields.items() if array is not None}
    layout = state_layout(names, tuple(present))
    block = layout.blank(len(times))
    numbers = layout.views(block, len(times))
    numbers["stamp"][:] = np.stack(np.divmod(times, NS), axis=-1)
    for name, array in present.items():
        numbers[name][:] = array
    raw = block.tobytes()
    return [raw[i : i + layout.size] for i in range(0, len(raw), layout.size)]
