"""What is usual on a machine, as one record shows it: the scales of all that is fitted."""

from __future__ import annotations

import numpy as np

from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine

from ..data.motion import coordinates, measured_by
from ..data.record import Record


def scales_of(machine: Machine, record: Record) -> Scales:
    """What is usual: rms of drive, coordinates of the joints, their rates, and the force that the drive makes at rest, or that moves what
    nothing drives."""
    n = len(machine.joints)
    q = coordinates(machine, record)[:, sorted(measured_by(machine, record))]
    q = q - np.nanmean(q, axis=0)
    smooth = np.stack([np.convolve(c, np.ones(5) / 5, "valid") for c in q.T], 1)  # NaN where one was
    coordinate = float(np.sqrt(np.nanmean(smooth**2)))
    within = np.delete(np.diff(smooth, axis=0), [b - 4 + i for b in record.breaks for i in range(5)], axis=0)
    rate = float(np.sqrt(np.nanmean(within**2))) / record.step
    drive = float(np.sqrt(np.mean((record.drives - record.drives.mean(0)) ** 2)))
    zero, time = (0.0,) * n, coordinate / rate
    if not record.driven.any():
        mass = np.sqrt(np.mean([machine.diagonal(machine.at_rest.mass, j) ** 2 for j in range(n)]))
        return Scales(float(mass) * coordinate / time**2, coordinate, time, 1.0, record.span)
    force = np.sqrt(np.mean(np.square(machine.terms(zero, zero, zero, (drive,) * n).drive)))
    return Scales(float(force), coordinate, time, drive, record.span)
