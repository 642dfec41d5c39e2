"""What a residual is learned from: measured samples of a suspended run, in the leg frame, at the simulator's own step.

Only time, drive voltages, hip angles and actuator tips (or, where there are none, angles alone) are read. Rates and
accelerations are differentiated from the angles: a local polynomial of degree 5 over a window whose width generalised
cross-validation picks from the data. Noise-free angles get the narrowest window and rates good to 1e-4; with encoder noise the
window widens until the polynomial stops following the noise. It is local, so the kinks of end stops stay where they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.signal import savgol_coeffs, savgol_filter

from hamr_description.errors import BagError
from hamr_description.names import JOINTS, LEGS, drive_sign, joint_signs
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ, SERVO_MS
from hamr_description.units import length_from_si, rate_from_si
from hamr_dynamics.leg_step import LANES, LegStep

from .simple import simple_parameters

DEGREE = 5
HALF_WIDTHS = (3, 4, 5, 6, 8, 10, 13, 16, 20, 25, 32, 40, 50, 64, 80)
CLEAR = 0.97  # of the way to an end stop: beyond it, samples tell about stops, not about the leg
SIGNS = np.array([joint_signs(leg) for leg in LEGS], float)[:, None]  # (4, 1, 2)
DRIVE_SIGNS = np.array([drive_sign(leg) for leg in LEGS], float)[:, None, None]


class Measured(Protocol):
    """What `hamr_bags.reader.load` gives; SI, columns in canonical joint order, (n, 8) each."""

    time: np.ndarray
    voltages: np.ndarray
    angles: np.ndarray
    deflections: np.ndarray | None
    rates: np.ndarray | None
    environment: str
    sample_hz: float

    @property
    def pieces(self) -> list[slice]: ...


@dataclass(frozen=True, slots=True)
class Stretch:
    """Gapless samples, one every 50 us, (legs, n, 2) each in the leg frame.

    Attributes:
        angles: as measured, rad.
        q, v: smoothed angles, rad, and their rates, rad/ms.
        drive: voltages minus neutral, held to the next sample, V.
        inside: (legs, n) whether both actuators of a leg are clear of their end stops.
        half_width: of the smoothing window, samples.
    """

    angles: np.ndarray
    q: np.ndarray
    v: np.ndarray
    drive: np.ndarray
    inside: np.ndarray
    half_width: int

    def __len__(self) -> int:
        return self.q.shape[1]


@dataclass(frozen=True, slots=True)
class Windows:
    """Parts of equal length, one leg each, in blocks of 16 for compiled loops: (blocks, rows * 16) and (blocks, steps, rows * 16).

    Attributes:
        state0: smoothed state at the start, rows q q v v a a (rad, ms). drive: V from neutral, two rows a step.
        goal: measured angles after each step, rad. param: parameters of each window's leg (`LegStep.parameters`).
    """

    state0: np.ndarray
    drive: np.ndarray
    goal: np.ndarray
    param: np.ndarray

    def __len__(self) -> int:
        return len(self.state0)

    def __getitem__(self, blocks: slice) -> Windows:
        return Windows(self.state0[blocks], self.drive[blocks], self.goal[blocks], self.param[blocks])


def stretches(recording: Measured) -> list[Stretch]:
    """The gapless parts of a recording, long enough to differentiate; BagError if it does not fit.

    Bags sampled below 20 kHz are brought to 20 kHz by cubic interpolation, of the voltages too: good for band-limited drive,
    not for steps.
    """
    if recording.environment not in ("suspended", ""):
        raise BagError(f"A residual is learned from a suspended run, not '{recording.environment}': collect one with the chassis fixed.")
    if recording.angles.shape[1:] != (len(JOINTS),):
        raise BagError(f"Angles have shape {recording.angles.shape}: they need one column for each of {', '.join(JOINTS)}.")
    ratio = round(SERVO_HZ / recording.sample_hz)
    if ratio < 1 or abs(ratio * recording.sample_hz - SERVO_HZ) > 1e-6 * SERVO_HZ:
        raise BagError(f"Samples come at {recording.sample_hz} Hz: {SERVO_HZ} Hz must be a whole multiple of that.")
    shortest = 2 * HALF_WIDTHS[0] + 1
    found = [_stretch(recording, piece, ratio) for piece in recording.pieces if piece.stop - piece.start > shortest]
    if not found:
        raise BagError(f"The recording has no gapless stretch of more than {shortest} samples.")
    return found


def by_leg(x: np.ndarray, signs=1.0) -> np.ndarray:
    """(n, 8) columns in canonical order -> (legs, n, 2), times signs."""
    return x.reshape(len(x), len(LEGS), 2).transpose(1, 0, 2) * signs


def _stretch(recording: Measured, piece: slice, ratio: int) -> Stretch:
    angles = by_leg(recording.angles[piece], SIGNS)
    half, step = best_half_width(angles), ratio * SERVO_MS
    q, v = (savgol_filter(angles, 2 * half + 1, DEGREE, deriv=d, delta=step, axis=1) for d in (0, 1))
    if recording.rates is not None:
        v = rate_from_si(by_leg(recording.rates[piece], SIGNS))
    drive = by_leg(recording.voltages[piece] - value("actuator.neutral_voltage"), DRIVE_SIGNS)
    inside = _inside(recording, piece, q, half)
    if ratio > 1:
        grid = np.arange(angles.shape[1]) * step
        n = (len(grid) - 1) * ratio + 1
        fine = np.arange(n) * SERVO_MS
        spline = CubicHermiteSpline(grid, q, v, axis=1)
        q, v = spline(fine), spline(fine, 1)
        drive = CubicHermiteSpline(grid, drive, np.gradient(drive, step, axis=1), axis=1)(fine)
        earlier = np.arange(n) // ratio
        inside = inside[:, earlier] & inside[:, np.minimum(earlier + 1, len(grid) - 1)]
        angles = CubicSpline(grid, angles, axis=1)(fine)
    return Stretch(angles, q, v, drive, inside, half)


def best_half_width(angles: np.ndarray) -> int:
    """Half width of the smoothing window by generalised cross-validation: least residual over (1 - own weight)^2, all channels pooled."""
    score = {}
    for half in HALF_WIDTHS:
        if 2 * half + 1 >= angles.shape[1]:
            break
        own = savgol_coeffs(2 * half + 1, DEGREE)[half]
        inner = (savgol_filter(angles, 2 * half + 1, DEGREE, axis=1) - angles)[:, half : angles.shape[1] - half]
        score[half] = float(np.mean(inner**2)) / (1 - own) ** 2
    return min(score, key=score.get)


def _inside(recording: Measured, piece: slice, q: np.ndarray, half: int) -> np.ndarray:
    if recording.deflections is not None:
        tips = length_from_si(by_leg(recording.deflections[piece]))
        clear = (np.abs(tips) < CLEAR * value("actuator.stop")).all(-1)
    else:
        p = simple_parameters(LEGS[0])
        low, high = np.array(p["stop_low"]), np.array(p["stop_high"])
        clear = ((q > CLEAR * low) & (q < CLEAR * high)).all(-1)
    # smoothing and differencing carry a touch over a window's width
    reach = np.ones(2 * half + 3)
    return np.stack([np.convolve(~row, reach, "same") < 0.5 for row in clear])


def windows(parts: Sequence[Stretch], steps: int, step: LegStep) -> Windows:
    """All windows of `steps` steps, one after the other, in which the leg stays clear of its stops; BagError if that leaves under 16."""
    gravity = value("robot.gravity")
    parameters = [step.parameters(leg, gravity=gravity) for leg in LEGS]
    state0, drive, goal, param = [], [], [], []
    for part in parts:
        before = np.diff(part.v, axis=1) / SERVO_MS  # acceleration of the step that ends at sample k + 1
        for leg, k in product(range(len(LEGS)), range(1, len(part) - steps, steps)):
            if part.inside[leg, k : k + steps + 1].all():
                state0.append((part.q[leg, k], part.v[leg, k], before[leg, k - 1]))
                drive.append(part.drive[leg, k : k + steps])
                goal.append(part.angles[leg, k + 1 : k + steps + 1])
                param.append(parameters[leg])
    whole = len(state0) // LANES * LANES
    if not whole:
        raise BagError(f"{len(state0)} windows of {steps * SERVO_MS:g} ms stay clear of the stops, {LANES} are needed: record longer.")

    def blocks(rows, *shape):
        lanes = np.array(rows[:whole]).reshape(-1, LANES, *shape)
        return np.ascontiguousarray(np.moveaxis(lanes, 1, -1)).reshape(whole // LANES, *shape[:-1], -1)

    return Windows(blocks(state0, 6), blocks(drive, steps, 2), blocks(goal, steps, 2), blocks(param, len(parameters[0])))


def digest(recordings: Sequence[Measured]) -> list[str]:
    """Hash of what is read of each recording, 16 hex digits."""
    found = []
    for r in recordings:
        sha = hashlib.sha256(f"{r.environment} {r.sample_hz}".encode())
        for x in (r.time, r.voltages, r.angles, r.deflections, r.rates):
            sha.update(b"" if x is None else np.ascontiguousarray(x, "<f8").tobytes())
        found.append(sha.hexdigest()[:16])
    return found
