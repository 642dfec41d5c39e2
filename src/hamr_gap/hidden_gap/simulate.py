"""A case's noise-free run."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache

import numpy as np

from hamr_bags.excitation import excitation
from hamr_description import names
from hamr_description.errors import ModelError
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ, SERVO_MS
from hamr_description.units import length_to_si, time_to_si

from .case import JOINTS, Case, Effect, Truth
from .laws.law import LAWS, SIZE, address
from .laws.sensor import sensed
from .loop import run, step_address
from .machine import TIME_SHIFT, change, machine, rest_mass

#: Samples kept per second, and every how many servo samples.
SAMPLE_HZ = 4000
EVERY = SERVO_HZ // SAMPLE_HZ


def simulate(case: Case, *, without: Collection[str] = ()) -> Truth:
    """Run a case without noise; `without`: families or laws to leave out. ModelError if the run diverges."""
    effects = [effect for effect in case.effects if effect.family not in without and effect.law not in without]
    return play(effects, case.changes, case.excitation, step=case.step)


def play(effects: Sequence[Effect], changes: Mapping[str, float], signal: Mapping, *, step: float) -> Truth:
    """Run the leg with effects and parameter changes under an excitation, `step` in ms (a divisor of 0.05)."""
    return driven(effects, changes, commands(**signal), step=step)


def driven(effects: Sequence[Effect], changes: Mapping[str, float], volts: np.ndarray, *, step: float) -> Truth:
    """The same under any voltages (n, 2) V at 20 kHz."""
    angles, tips = _integrate(effects, changes, volts, step)
    angles = angles * change(changes, "sensor_gain") + change(changes, "bias")
    tips = tips * change(changes, "tip_gain") + change(changes, "tip_bias")
    for effect in effects:
        if LAWS[effect.law].sensor:
            for joint in effect.joints:
                i = JOINTS.index(joint)
                angles[:, i] = sensed(effect.law, angles[:, i], effect.parameters)
    if changes.get(TIME_SHIFT, 0.0):
        angles, tips = (_late(column, changes[TIME_SHIFT]) for column in (angles, tips))
    if not np.isfinite(angles).all():
        raise ModelError(f"the hidden machine diverges with {[effect.law for effect in effects]}; draw another seed.")
    kept = slice(None, None, EVERY)
    return Truth(np.arange(len(volts))[kept] / SERVO_HZ, volts[kept], angles[kept], length_to_si(tips[kept]))


def rough(changes: Mapping[str, float], signal: Mapping, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Hip angles (n, 2) rad and tips (n, 2) mm of the leg without effects at 4 kHz, `parts` steps a sample; sensors' changes apart."""
    hold = EVERY * SERVO_MS
    volts = commands(**signal)
    return _integrate((), changes, volts.reshape(-1, EVERY, 2).mean(axis=1), hold / parts, hold)


@lru_cache(maxsize=4)
def _commands(signal: tuple) -> np.ndarray:
    columns = [names.JOINTS.index(joint) for joint in JOINTS]
    return np.ascontiguousarray(excitation(**dict(signal)).voltages[:, columns])


def commands(**signal) -> np.ndarray:
    """(n, 2) V at 20 kHz: the leg's channels of an excitation."""
    return _commands(tuple(sorted(signal.items())))


def _integrate(
    effects: Sequence[Effect], changes: Mapping[str, float], volts: np.ndarray, step: float, hold: float = SERVO_MS
) -> tuple[np.ndarray, np.ndarray]:
    """Angles (n, 2) rad and tips (n, 2) mm at the start of each of n voltages, held for `hold` ms each."""
    series = {JOINTS.index(joint) for effect in effects if LAWS[effect.law].machine == "series" for joint in effect.joints}
    flywheels = [effect.parameters for effect in effects if LAWS[effect.law].machine == "coupled"]
    coupling = sum(float(np.copysign(parameters["inertia"], parameters["sense"])) for parameters in flywheels)
    leg = machine(changes, step=step, series=tuple(sorted(series)), coupling=coupling)
    addresses, joints, first_p, first_s, p, states = [], [], [], [], [], 0
    for effect in sorted(effects, key=lambda effect: list(LAWS).index(effect.law)):  # as registered: from the drive to the leg
        if LAWS[effect.law].sensor or LAWS[effect.law].machine == "coupled":
            continue
        law = LAWS[effect.law]
        for joint in effect.joints:
            addresses.append(address(effect.law))
            joints.append(JOINTS.index(joint))
            first_p.append(len(p))
            first_s.append(states)
            states += law.count(effect.parameters, step)
        p.extend(law.numbers(effect.parameters, step))
    data, angles, tips = leg.data, np.empty(volts.shape), np.empty(volts.shape)
    mass = 1.0 / np.diag(np.linalg.inv(rest_mass()))
    run(
        step_address(), leg.model._address, data._address,
        data.qpos, data.qvel, data.ctrl, data.qfrc_applied, data.qfrc_bias, leg.model.dof_armature, leg.dofs, leg.rotors, leg.stops, mass,
        leg.ratio, leg.gain, change(changes, "preload"), value("actuator.neutral_voltage"), volts, round(hold / step), step,
        *(np.array(numbers, np.int64) for numbers in (addresses, joints, first_p, first_s)),
        np.array([*p, 0.0]), np.zeros(states + 1), np.zeros(SIZE), angles, tips,
    )  # fmt: skip
    return angles, tips


def _late(columns: np.ndarray, shift: float) -> np.ndarray:
    """Columns (n, 2) at 20 kHz, seen `shift` ms late."""
    t = np.arange(len(columns)) / SERVO_HZ
    return np.stack([np.interp(t - time_to_si(shift), t, column) for column in columns.T], axis=1)
