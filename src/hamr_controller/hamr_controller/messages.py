"""The messages of one period as bytes, filled from arrays; the same for nodes and for a run without ROS."""

from __future__ import annotations

import numpy as np

from hamr_bags import frames
from hamr_bags.cdr import string
from hamr_bags.layout import Frame
from hamr_bags.run_info import RunInfo
from hamr_description import urdf
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import SUBSTEPS
from hamr_dynamics.effects.effects_file import EffectsFile

#: Rows of an engine's sample (architecture.md, ROWS), their number, and the length of its base state.
POSITION, VELOCITY, DEFLECTION, DEFLECTION_RATE, TORQUE, FORCE, ACCELERATION = range(7)
ROWS, BASE_SIZE = 7, 13


class StateMessages:
    """What the simulator publishes.

    Args:
        samples_per_frame: servo samples kept of each period in the servo topics.
    """

    def __init__(self, samples_per_frame: int):
        self._step = SUBSTEPS // samples_per_frame
        self._clock = Frame(frames.clock_layout())
        self._joints = Frame(frames.state_layout(JOINTS))
        self._odometry = Frame(frames.odometry_layout())
        self._servo_joints = frames.servo_frame(Topic.SERVO_JOINTS, samples_per_frame)
        self._servo_actuators = frames.servo_frame(Topic.SERVO_ACTUATORS, samples_per_frame)

    def state(self, time_ns: int, sample: np.ndarray, base: np.ndarray) -> dict[str, bytes]:
        """Topic -> message of the state at the start of a period: sample (7, 8), base (13,), SI."""
        joints, odometry = self._joints.numbers, self._odometry.numbers
        joints["position"][:], joints["velocity"][:], joints["effort"][:] = sample[POSITION], sample[VELOCITY], sample[TORQUE]
        odometry["position"][:], odometry["orientation"][:] = base[:3], base[3:7]
        odometry["linear"][:], odometry["angular"][:] = base[7:10], base[10:]
        # The policy answers /joint_states, so that goes last.
        return _stamped(time_ns, {Topic.CLOCK: self._clock, Topic.ODOM: self._odometry, Topic.JOINT_STATES: self._joints})

    def servo(self, time_ns: int, samples: np.ndarray) -> dict[str, bytes]:
        """Topic -> message of the samples (80, 7, 8) of a period."""
        kept = samples[:: self._step]
        joints, actuators = self._servo_joints.numbers, self._servo_actuators.numbers
        joints["positions"][:], joints["velocities"][:] = kept[:, POSITION], kept[:, VELOCITY]
        joints["accelerations"][:], joints["effort"][:] = kept[:, ACCELERATION], kept[:, TORQUE]
        actuators["positions"][:], actuators["velocities"][:] = kept[:, DEFLECTION], kept[:, DEFLECTION_RATE]
        actuators["effort"][:] = kept[:, FORCE]
        return _stamped(time_ns, {Topic.SERVO_JOINTS: self._servo_joints, Topic.SERVO_ACTUATORS: self._servo_actuators})


class VoltageMessages:
    """What a driver publishes; samples_per_frame as for StateMessages."""

    def __init__(self, samples_per_frame: int):
        self._frame = frames.servo_frame(Topic.SERVO_VOLTAGES, samples_per_frame)
        self._step = SUBSTEPS // samples_per_frame

    def voltages(self, time_ns: int, volts: np.ndarray) -> bytes:
        """Message of the drive voltages (80, 8) of a period."""
        self._frame.numbers["effort"][:] = volts[:: self._step]
        self._frame.stamp(time_ns)
        return bytes(self._frame)


class TargetMessages:
    """What a policy publishes."""

    def __init__(self):
        self._frame = Frame(frames.state_layout(JOINTS, ("position",)))

    def targets(self, time_ns: int, target: np.ndarray) -> bytes:
        """Message of target hip angles (8,) rad that answer the state of a time."""
        self._frame.numbers["position"][:] = target
        self._frame.stamp(time_ns)
        return bytes(self._frame)


def announcements(engine, samples_per_frame: int, seed: int, excitation: dict) -> dict[str, bytes]:
    """Topic -> message of what a simulator says once: /run_info and /robot_description."""
    effects = getattr(engine, "effects", EffectsFile())
    info = RunInfo.of_simulation(
        environment=engine.environment,
        samples_per_frame=samples_per_frame,
        backend=engine.backend,
        engine=engine.engine,
        seed=seed,
        excitation=excitation,
        effects=effects.entries,
        effects_hash=effects.hash,
    )
    return {Topic.RUN_INFO: string(info.to_json()), Topic.ROBOT_DESCRIPTION: string(urdf.build())}


def _stamped(time_ns: int, messages: dict[str, Frame]) -> dict[str, bytes]:
    for frame in messages.values():
        frame.stamp(time_ns)
    return {topic: bytes(frame) for topic, frame in messages.items()}
