"""Experiments with the leg, each a panel: what was done, what came of it, and how to read it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hamr_dynamics.effects.si import si_factor

from .figure import Panel, pair
from .leg import LIFT, STEP, SWING, TIP, Bench, eased, leg

SLOW = (60.0, 25.0)  # V of slow drives
PERIOD = 2000.0  # ms of a slow triangle
SMALL = (4.0, 1.0)  # V of sines about the resonance
BIASES = (0.0, 60.0, -60.0)  # V about which small sines run
BAND = np.arange(20.0, 200.1, 2.5)  # Hz about the resonance
LOW_BAND = np.geomspace(4.0, 63.0, 25)  # Hz below it
LEVEL_HZ, LEVELS = 20.0, np.geomspace(2.0, 100.0, 24)  # V
RUNS = ("", "second", "third")
ANGLE, DRIVE = "swing angle, rad", "drive, V"


def slow(bench: Bench, volts: float, cycles: float = 1.25, every: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Drive (n,) V and readings (2, n, channels), one in `every` steps, of a slow triangle from rest."""
    t = np.arange(round(cycles * PERIOD / STEP)) * STEP
    drive = volts * (1.0 - 4.0 * np.abs(np.mod(t / PERIOD + 0.25, 1.0) - 0.5))
    return drive[::every], bench.run([drive], every)[:, 0]


def triangle(bench: Bench) -> Panel:
    curves = []
    for volts, run in zip(SLOW, RUNS, strict=False):
        drive, y = slow(bench, volts)
        curves += pair(drive, y[..., SWING], run)
    return Panel(
        f"slow triangles,\n{SLOW[0]:g} V, {SLOW[1]:g} V (dashed)", DRIVE, ANGLE, tuple(curves),
        "angle against drive, slower than all dynamics: the leg alone is a straight line",
    )  # fmt: skip


def fan(bench: Bench) -> Panel:
    drive, y = slow(bench, SLOW[0], 3.25)
    return Panel(
        "the same slow triangle\nthree times", DRIVE, ANGLE, pair(drive, y[..., SWING]),
        "angle against drive over three periods: what changes with time leaves its line",
    )  # fmt: skip


def tip(bench: Bench) -> Panel:
    curves = []
    for volts, run in zip(SLOW, RUNS, strict=False):
        y = slow(bench, volts)[1]
        curves += pair(y[..., SWING], y[..., TIP], run)
    return Panel(
        "the same: actuator\nagainst joint", ANGLE, "actuator tip, mm", tuple(curves),
        "both ends of the transmission: where they do not move together the effect is between them",
    )  # fmt: skip


def gain(bench: Bench) -> Panel:
    curves = [c for volts, run in zip(SMALL, RUNS, strict=False) for c in pair(BAND, np.abs(bench.response(BAND, volts)), run)]
    return Panel(
        f"sines of {SMALL[0]:g} V,\n{SMALL[1]:g} V (dashed)", "Hz", "gain, rad/V", tuple(curves),
        "angle over drive about the resonance: of a linear leg it is the same at every amplitude", log="y",
    )  # fmt: skip


def level(bench: Bench) -> Panel:
    gains = np.stack([np.abs(bench.response(np.array([LEVEL_HZ]), volts))[:, 0] for volts in LEVELS], 1)
    return Panel(
        f"sines of {LEVEL_HZ:g} Hz", "amplitude, V", "gain, rad/V", pair(LEVELS, gains),
        "angle over drive well below the resonance: of a linear leg it does not depend on the amplitude", log="x",
    )  # fmt: skip


def phase(bench: Bench) -> Panel:
    response = bench.response(BAND, SMALL[1])
    return Panel(
        f"sines of {SMALL[1]:g} V", "Hz", "phase, rad", pair(BAND, np.unwrap(np.angle(response), axis=1)),
        "angle against drive: a delay adds a straight line through zero, a lag one that levels off",
    )  # fmt: skip


def biased(bench: Bench) -> Panel:
    pairs = zip(BIASES, RUNS, strict=True)
    curves = [c for bias, run in pairs for c in pair(BAND, np.abs(bench.response(BAND, SMALL[1], bias)), run)]
    return Panel(
        f"sines of {SMALL[1]:g} V about 0,\n{BIASES[1]:g} V (dashed), {BIASES[2]:g} V (dotted)", "Hz", "gain, rad/V", tuple(curves),
        "small motions about three angles: the leg alone is the same at all of them", log="y",
    )  # fmt: skip


def loss(bench: Bench) -> Panel:
    torque = si_factor("F") * leg().terms((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 0.0)).drive[0]  # N m/V
    return Panel(
        f"Im(torque / angle),\nsines of {SMALL[0]:g} V", "Hz", "loss, 1e-6 N m/rad",
        pair(LOW_BAND, 1e6 * (torque / bench.response(LOW_BAND, SMALL[0])).imag),
        "the part of torque over angle that loses energy: of a viscous damper it grows in proportion to frequency",
    )  # fmt: skip


def hold(bench: Bench) -> Panel:
    t = np.arange(round(4000.0 / STEP)) * STEP
    drive = SLOW[0] * (eased((t - 200.0) / 60.0) - eased((t - 2700.0) / 60.0))
    every = 400
    y = bench.run([drive], every)[:, 0, :, SWING]
    return Panel(
        f"{SLOW[0]:g} V held for 2.5 s", "s", ANGLE, pair(1e-3 * t[::every], y), "what moves while the drive holds, and after it is gone"
    )


def step(bench: Bench) -> Panel:
    t = np.arange(round(25.0 / STEP)) * STEP
    every = 2
    y = bench.run([np.where(t >= 3.0, SLOW[1], 0.0)], every)[:, 0, :, SWING]
    return Panel(f"a step of {SLOW[1]:g} V at 3 ms", "ms", ANGLE, pair(t[::every], y), "when the answer begins, and how sharply")


def release(bench: Bench) -> Panel:
    t = np.arange(round(460.0 / STEP)) * STEP
    every = 10
    y = bench.run([np.where(t < 320.0, SLOW[0] * eased(t / 300.0), 0.0)], every)[:, 0, :, SWING]
    shown = t[::every] >= 315.0
    return Panel(
        f"let go from {SLOW[0]:g} V", "ms", ANGLE, pair((t[::every] - 320.0)[shown], y[:, shown]),
        "the swing dies away: exponentially with viscous damping, along straight lines with dry friction",
    )  # fmt: skip


def other(bench: Bench) -> Panel:
    bench = Bench(bench.placed, clamped=False)
    drive, y = slow(bench, SLOW[0])
    return Panel(
        "slow triangle on the swing",
        "swing drive, V",
        "lift angle, rad",
        pair(drive, y[..., LIFT]),
        "the joint that is not driven, slowly",
    )


def other_gain(bench: Bench) -> Panel:
    response = Bench(bench.placed, clamped=False).response(BAND, SMALL[1], channel=LIFT)
    return Panel(
        f"sines of {SMALL[1]:g} V on the swing", "Hz", "lift angle, rad/V", pair(BAND, np.abs(response)),
        "the joint that is not driven, about its resonances; the leg's own inertia couples the two there", log="y",
    )  # fmt: skip


def own_gain(bench: Bench) -> Panel:
    response = Bench(bench.placed, clamped=False).response(BAND, SMALL[1])
    return Panel(
        "the same: the swing itself", "Hz", "swing angle, rad/V", pair(BAND, np.abs(response)),
        "the joint that is driven", log="y",
    )  # fmt: skip


def _sensed(bench: Bench) -> np.ndarray:
    """(2, n) readings of half a slow triangle, from one end to the other."""
    y = slow(bench, SLOW[0], 0.75, 20)[1][..., SWING]
    return y[:, y.shape[1] // 3 :]


def reading(bench: Bench) -> Panel:
    y = _sensed(bench)
    return Panel(
        "slow triangle:\nreading against truth", "true angle, rad", "reading, rad", pair(y[0], y), "what the sensor says of the angle"
    )


def error(bench: Bench) -> Panel:
    y = _sensed(bench)
    return Panel("its error", "true angle, rad", "reading - truth, rad", pair(y[0], y - y[0]), "the difference of the two")


EXPERIMENTS: dict[str, Callable[[Bench], Panel]] = {
    f.__name__: f
    for f in (triangle, fan, tip, gain, level, phase, biased, loss, hold, step, release, other, other_gain, own_gain, reading, error)
}
