"""What is shown of each effect: its size, and the experiments. What stands in no table follows from the kind of law."""

from __future__ import annotations

from collections.abc import Mapping

from hamr_dynamics.bank_stages import USUAL
from hamr_dynamics.effects.effects_file import OF_LEGS, OF_THE_CHASSIS, PlacedEffect
from hamr_dynamics.effects.law import Effect, Form, Parameter
from hamr_dynamics.effects.places import WORDS
from hamr_dynamics.effects.si import si_factor

from ..walking.setting import OF_JOINTS
from .experiments import EXPERIMENTS
from .figure import Panel
from .leg import LEG, Bench
from .walk import PICTURES, Walks

TIMES_TYPICAL = 5.0  # how large sizes are shown, unless the table says otherwise
#: Sizes in SI that are plain to see beside a leg of 5.0e-4 N m/rad, 1.0e-9 kg m^2 and 1.5e-6 N m/V.
SIZES: Mapping[str, Mapping[str, float]] = {
    "added_mass": {"mass": 8e-4, "x": 0.01, "y": 0.0, "z": 0.005},
    "air_drag": {"coefficient": 0.5},
    "backlash": {"play": 0.03, "share": 0.7},
    "configuration_dependent_damping": {"slope": 1.5e-7, "curvature": 0.0},
    "configuration_dependent_inertia": {"slope": 2e-9, "curvature": 0.0},
    "configuration_dependent_stiffness": {"depth": 1e-6, "centre": 0.08, "width": 0.06},
    "configuration_dependent_transmission": {"second": 1.5, "third": 0.0, "share": 0.7},
    "coulomb_friction": {"level": 6e-6, "width": 0.02},
    "cubic_stiffness": {"cubic": 6e-3},
    "drive_delay": {"delay": 2e-3},
    "drive_drift": {"rate": 0.1},
    "drive_lag": {"time": 2e-3},
    "drive_saturation": {"curvature": 5e-4},
    "end_stop": {"stiffness": 5e-3, "limit": 0.1, "damping": 1e-7},
    "force_table": {f"f{i}{j}": 1.5e-5 * min(2 - i, 0) for i in range(5) for j in range(5)} | {"angle": 0.1, "rate": 100.0},
    "gravity_tilt": {"roll": 0.1, "pitch": 0.0},
    "ground_compliance": {"stiffness": -0.9, "damping": -0.9},
    "ground_friction": {"change": -0.8},
    "lift_swing_coupling": {"stiffness": 1.5e-4},
    "piezo_creep": {"size": 0.2, "time": 0.4},
    "piezo_hysteresis": {"size": 0.4, "width": 20.0},
    "quadratic_damping": {"coefficient": 1e-9},
    "rail_crosstalk": {"share": 0.3},
    "sensor_lag": {"time": 2e-3},
    "sensor_latency": {"delay": 2e-3},
    "sensor_nonlinearity": {"second": 1.5, "third": 0.0},
    "sensor_quantisation": {"step": 0.03, "offset": 0.0},
    "serial_compliance": {"compliance": 1e3, "share": 0.7},
    "spring_hysteresis": {"size": 2e-5, "distance": 0.08, "skew": -0.6},
    "stribeck_friction": {"level": 2e-6, "excess": 1e-5, "speed": 2.0, "width": 0.02},
    "structural_damping": {"loss": 5e-5, "time": 8e-3},
    "tether_force": {"x": 0.0, "y": 1.5e-3, "z": 0.0},
    "unit_scale": {"change": 1.0},
    "viscoelasticity": {"stiffness": 1.5e-4, "time": 0.4},
    "voltage_dependent_gain": {"slope": 0.01},
}
#: Experiments of single effects whose kind does not say enough.
PANELS: Mapping[str, tuple[str, ...]] = {
    "backlash": ("triangle", "tip", "level"),
    "configuration_dependent_damping": ("triangle", "biased"),
    "configuration_dependent_inertia": ("triangle", "biased"),
    "configuration_dependent_stiffness": ("triangle", "biased"),
    "configuration_dependent_transmission": ("triangle", "tip", "biased"),
    "coulomb_friction": ("triangle", "level", "release"),
    "drive_drift": ("hold", "fan"),
    "force_table": ("triangle", "biased"),
    "rail_crosstalk": ("other", "other_gain", "own_gain"),
    "serial_compliance": ("triangle", "tip", "gain"),
    "spring_hysteresis": ("triangle", "level", "release"),
    "stribeck_friction": ("triangle", "level", "release"),
    "air_drag": ("way", "path", "pitch"),
    "gravity_tilt": ("path", "way"),
    "ground_compliance": ("drop", "height", "pitch"),
}


def typical(form: Form, parameter: Parameter) -> float:
    """Typical size in SI, on a leg of HAMR-simple or on the robot."""
    return parameter.typical * unit_of(form, parameter)


def unit_of(form: Form, parameter: Parameter) -> float:
    """SI value of what the library's typical sizes and bounds are in."""
    return (USUAL.of(parameter.dimension) if form.acts in OF_JOINTS else 1.0) * si_factor(parameter.dimension)


def example(effect: Effect) -> PlacedEffect:
    """The effect as it is shown, in its first form."""
    form = effect.forms[0]
    usual = {p.name: float(f"{typical(form, p) * (1.0 if p.shape else TIMES_TYPICAL):.1g}") for p in form.parameters}
    joints = (
        ()
        if form.acts in OF_THE_CHASSIS
        else WORDS[LEG]
        if form.acts in OF_LEGS
        else (f"{LEG}_{'lift' if experiments(effect)[0] == 'other' else 'swing'}",)
    )
    if effect.part == "contact":
        joints = WORDS["all"]  # one foot of four is hard to see
    return PlacedEffect(effect.name, form.name, joints, SIZES.get(effect.name, usual))


def experiments(effect: Effect) -> tuple[str, ...]:
    """Names of EXPERIMENTS, or of PICTURES for what acts on the ground only."""
    form = effect.forms[0]
    if effect.name in PANELS:
        return PANELS[effect.name]
    if form.acts not in OF_JOINTS:
        return ("path", "height", "pitch")
    if form.acts == "pair":
        return ("other", "other_gain", "own_gain")
    if any(p.dimension == "T" for p in form.sizes):
        return ("step", "gain", "phase")  # late
    if any(p.dimension == "T" for p in form.shapes):
        return ("hold", "triangle", "loss")  # it remembers for a time
    return {"drive": ("triangle", "level"), "force": ("triangle", "release", "gain"), "sense": ("reading", "error")}[form.acts]


def panels(effect: Effect) -> list[Panel]:
    """The pictures of an effect, simulated."""
    names, placed = experiments(effect), example(effect)
    if placed.law.acts in OF_JOINTS:
        return [EXPERIMENTS[name](Bench(placed)) for name in names]
    run = Walks(placed)
    return [PICTURES[name](run) for name in names]
