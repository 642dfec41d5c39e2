"""Effects files: what is read is what was written, and what is wrong is said in one sentence that names the file."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS, LEGS
from hamr_dynamics.effects.bank import CHANGES
from hamr_dynamics.effects.effects_file import OF_LEGS, OF_THE_CHASSIS, Change, EffectsFile, PlacedEffect, read, write
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.si import si_factor, si_unit
from hamr_dynamics.set_effects import inside

FORMS = [(name, form) for name, effect in library().items() for form in effect.forms]
GOOD = """
effects:
  - effect: coulomb_friction
    form: presliding
    joints: [fl_swing, rear]
    parameters: {level: {value: 1.8e-6, unit: N*m}, distance: 5e-3}
  - effect: added_mass
    parameters: {mass: 1e-4, x: 0, y: 0, z: 0.01}
changes:
  - {change: stiffness, joints: left, value: 1e-5, unit: N*m/rad}
"""


@st.composite
def placed(draw) -> PlacedEffect:
    name, form = draw(st.sampled_from(FORMS))
    if form.acts in OF_THE_CHASSIS:
        joints = ()
    elif form.acts in OF_LEGS:
        joints = tuple(draw(st.sets(st.sampled_from(LEGS), min_size=1)))
    else:
        joints = tuple(draw(st.sets(st.sampled_from(JOINTS), min_size=1)))
    values = {
        p.name: draw(st.floats(p.low, p.high) if p.dimension == "1" else st.floats(1e-300, 1e300)) for p in form.parameters
    }
    return PlacedEffect(name, form.name, joints, values)


@given(st.lists(placed(), max_size=3, unique_by=lambda e: (e.effect, e.form)), st.sampled_from(list(CHANGES)), st.floats(-0.9, 1e6))
def test_a_file_comes_back_to_the_last_bit(tmp_path_factory, effects, change, value):
    file = EffectsFile(tuple(effects), (Change(change, ("left",), value),))
    path = tmp_path_factory.mktemp("effects") / "a.yaml"
    write(file, path)
    assert read(path) == file
    assert read(path).hash == file.hash != EffectsFile(tuple(effects)).hash


def test_short_forms_and_units(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(GOOD)
    friction, payload = read(path).effects
    assert friction.joints == ("fl_swing", "rl_swing", "rl_lift", "rr_swing", "rr_lift")
    assert (payload.form, payload.joints) == ("point", ())
    assert read(path).changes[0].joints == ("fl_swing", "fl_lift", "rl_swing", "rl_lift")
    assert inside(friction) == pytest.approx({"level": 1.8e-3, "distance": 5e-3})  # N mm, rad
    assert inside(payload) == pytest.approx({"mass": 0.1, "x": 0.0, "y": 0.0, "z": 10.0})  # g, mm


def test_units_of_dimensions():
    assert [si_unit(d) for d in ("F/Q^3", "Q/F", "F*T^2/Q", "1", "1/T", "N*T^2/L^2")] == [
        "N*m/rad^3", "rad/(N*m)", "N*m*s^2/rad", "1", "1/s", "N*s^2/m^2",
    ]  # fmt: skip
    assert si_factor("F*T^2/Q") == pytest.approx(1e-9)  # g mm^2 to kg m^2
    scales = Scales(2.0, 3.0, 5.0, 7.0, 11.0)
    assert scales.of("F*T^2/Q^3") == pytest.approx(2 * 25 / 27) and scales.of("S/U") == pytest.approx(11 / 7)


BAD = {
    "unknown effect": ("coulomb_friction", "kulomb", "no effect 'kulomb'"),
    "unknown form": ("presliding", "sliding", "no form 'sliding'"),
    "no form": ("    form: presliding\n", "", "needs a form"),
    "unknown parameter": ("distance: 5e-3", "distanse: 5e-3", "no parameter 'distanse'"),
    "missing parameter": (", distance: 5e-3", "", "lacks its parameter 'distance'"),
    "unknown joint": ("fl_swing", "fl_knee", "no joint 'fl_knee'"),
    "joint twice": ("[fl_swing, rear]", "[rear, rl_swing]", "rl_swing is named twice"),
    "no joints": ("    joints: [fl_swing, rear]\n", "", "has no joints"),
    "joints of the chassis": ("added_mass\n", "added_mass\n    joints: [fl]\n", "leave joints out"),
    "other unit": ("unit: N*m}", "unit: N*mm}", "give it in N.m"),
    "other unit of a change": ("unit: N*m/rad", "unit: N*mm/rad", "give the value in N.m/rad"),
    "unknown key": ("    form:", "    shape: x\n    form:", "unknown key 'shape'"),
    "unknown key at the top": ("changes:", "change:", "unknown key 'change'"),
    "key twice": ("    form: presliding", "    form: presliding\n    form: sign", "'form' stands twice"),
    "no number": ("5e-3", "five", "is 'five'; give a finite number"),
    "not finite": ("5e-3", ".nan", "give a finite number"),
    "negative": ("1.8e-6", "-1.8e-6", "level is -1.8e-06; it must not be negative"),
    "zero": ("5e-3", "0", "distance is 0; it must be positive"),
    "impossible gain": ("stiffness, joints: left, value: 1e-5, unit: N*m/rad", "gain, joints: all, value: -1.5", "more than -1"),
    "unknown change": ("change: stiffness", "change: colour", "no change 'colour'"),
    "effects is no list": (GOOD, "effects: 3", "'effects' must be a list"),
    "no mapping": (GOOD, "- 1", "must be a mapping"),
    "no YAML": (GOOD, "effects: [", "is no YAML"),
    "list as key": (GOOD, "? [a]\n: 1", "is no YAML"),
    "huge": ("5e-3", "1" + 400 * "0", "give a finite number"),
    "nothing": (GOOD, "", "must be a mapping"),
    "code": (GOOD, "effects: !!python/object/apply:os.system [ls]", "is no YAML"),
    "same place twice": (
        "  - effect: added_mass", "  - {effect: coulomb_friction, form: presliding, joints: [rear], parameters: {level: 0, distance: 1}}\n"
        "  - effect: added_mass", "stands twice at rl_swing",
    ),
    "half a leg": ("effects:\n", "effects:\n  - {effect: lift_swing_coupling, form: stiffness, joints: [fl_swing],"
                   " parameters: {stiffness: 1}}\n", "acts on whole legs"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_one_sentence(tmp_path, case):
    good, bad, said = BAD[case]
    path = tmp_path / "bad.yaml"
    assert good in GOOD
    path.write_text(GOOD.replace(good, bad, 1))
    with pytest.raises(ConfigError, match=said) as error:
        read(path)
    sentence = str(error.value)
    assert "bad.yaml" in sentence
    assert "\n" not in sentence
    assert sentence.endswith(".")


def test_no_file(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read"):
        read(tmp_path / "none.yaml")
