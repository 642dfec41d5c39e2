"""What laws do when they are stepped: by integrators of our own, not by the kernels."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from hamr_dynamics.effects.law import Joint
from hamr_dynamics.effects.library import find

H = 0.01  # of an oscillator with mass 1, spring 1


def parameters(form, **given: float) -> dict[str, float]:
    """Neutral ones, but for those given."""
    values = {p.name: p.typical if p.shape else 0.0 for p in form.parameters} | given
    return {name: np.float64(value) for name, value in values.items()}  # 1 / 0 is infinite, as in the kernels


def free_decay(effect: str, form: str, turns: int, drive: float = 0.0, **given: float) -> tuple[np.ndarray, float]:
    """(amplitudes at successive maxima, angular frequency) of q'' + q = drive + force of the law, from q = 1 at rest; leapfrog."""
    law = find(effect, form)
    p, z, q, v = parameters(law, **given), (0.0,) * law.states, 1.0, 0.0
    tops, times, t = [1.0], [0.0], 0.0
    while len(tops) <= turns:
        middle = q + 0.5 * H * v
        push, z = law.law(Joint(middle, v, drive, 1.0, 1.0, t, H, 9.0), p, z)
        before, v = v, v + H * (drive + float(push.force) - middle) / (1.0 + 0.5 * H * float(push.damping))
        q, t = middle + 0.5 * H * v, t + H
        if before > 0.0 >= v:
            tops.append(q)
            times.append(t + H * v / (before - v))
    return np.array(tops), 2.0 * pi * turns / (times[-1] - times[0])


def driven(effect: str, form: str, omega: float, view, **given: float) -> complex:
    """Answer of a drive or sensor law to sin(omega t) in its steady state, relative to it."""
    law = find(effect, form)
    p, z, h = parameters(law, **given), (0.0,) * law.states, 2 * pi / omega / 400
    total = 0.0j
    for k in range(2400):
        signal = sin(omega * k * h)
        y, z = law.law(view(signal, h), p, z)
        if k >= 2000:
            total += float(y) * (sin(omega * k * h) + 1j * cos(omega * k * h)) * 2 / 400
    return total


def modulus(effect: str, form: str, omega: float, **given: float) -> complex:
    """Complex stiffness of a law whose joint moves as sin(omega t)."""
    law = find(effect, form)
    p, z, h = parameters(law, **given), (0.0,) * law.states, 2 * pi / omega / 200
    total, turns = 0.0j, max(3, round(20 * given.get("long", given.get("time")) * omega / (2 * pi)))
    for k in range(200 * turns):
        phase = omega * k * h
        push, z = law.law(Joint(sin(phase), omega * cos(phase), 0.0, 1.0, 1.0, 0.0, h, 9.0), p, z)
        if k >= 200 * (turns - 1):
            total -= float(push.force) * (sin(phase) + 1j * cos(phase)) * 2 / 200
    return total
