"""What of a gap has a name where something else is missing too."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from oscillator import oscillator

from hamr_dynamics.effects.library import library
from hamr_gap.answers.found import find
from hamr_gap.judging.part import part_of

GAP = 1000.0
FRICTION, STRIBECK, PLAY = "coulomb_friction", "stribeck_friction", "backlash"


def leaving(left: float, *effects: SimpleNamespace, parameters: int = 2) -> SimpleNamespace:
    """A hypothesis that leaves a share of the gap."""
    names = frozenset(c.effect for c in effects)
    return SimpleNamespace(effects=effects, names=names, left=1.0 + left * GAP, parameters=parameters)


def effect(name: str, form: int = 0) -> SimpleNamespace:
    return SimpleNamespace(effect=name, form=library()[name].forms[form].name)


def tried(*sets: tuple[str, float]) -> SimpleNamespace:
    """A search that tried sets of effects at one joint, each with the share of the gap that it leaves."""
    found = {names: leaving(left, *map(effect, names.split())) for names, left in sets}
    return SimpleNamespace(by_names=lambda: found, tried=list(found.values()), floor=1.0, base=SimpleNamespace(left=1.0 + GAP))


@pytest.mark.parametrize(("sets", "part"), [
    ([(FRICTION, 0.2), (PLAY, 0.5)], FRICTION),
    ([(FRICTION, 0.15), (PLAY, 0.27)], FRICTION),
    ([(FRICTION, 0.2), (PLAY, 0.28)], None),  # another explains nearly as much
    ([(FRICTION, 0.2), (STRIBECK, 0.25)], FRICTION),  # which is its like
    ([(FRICTION, 0.25), (STRIBECK, 0.2)], FRICTION),  # and holds it as a special case
    ([(FRICTION, 0.4), (PLAY, 0.9)], None),  # most of the gap is something else
    ([(f"{FRICTION} {PLAY}", 0.15), (FRICTION, 0.25), (PLAY, 0.9)], FRICTION),
    ([(f"drive_lag {PLAY} piezo_creep", 0.02), (FRICTION, 0.2), (PLAY, 0.9)], None),  # three names imitate anything
    ([(f"drive_lag {PLAY} {FRICTION}", 0.02), (FRICTION, 0.2), (PLAY, 0.9)], FRICTION),
    ([(f"{FRICTION} {PLAY}", 0.15), (f"drive_drift {FRICTION}", 0.2), (PLAY, 0.9)], FRICTION),  # beside it now one, now another
    ([(f"{FRICTION} {PLAY}", 0.15), (FRICTION, 0.6), (PLAY, 0.9)], f"{FRICTION} {PLAY}"),
    ([], None),
])  # fmt: skip
def test_a_part_is_in_all_sets_that_leave_little(sets, part, monkeypatch):
    def less(_, __, h, c):
        return leaving(0.5, *(e for e in h.effects if e is not c))

    monkeypatch.setattr("hamr_gap.judging.part.without", less)
    found = part_of(None, None, tried(("drive_lag", 0.95), *sets))
    assert found is None if part is None else [c.effect for c in found.effects] == part.split()


@pytest.mark.parametrize(("plain", "rich", "chosen"), [(0.2, 0.18, 0), (0.28, 0.18, 1), (0.18, 0.2, 0)])
def test_a_part_is_said_in_the_plainest_form_that_does_about_as_well(plain, rich, chosen):
    """Bristles that yield take up some of a spring that nobody knows, and slide at too much for it."""
    forms = [leaving(left, effect(FRICTION, form)) for form, left in ((0, plain), (1, rich))]
    state = tried(("drive_lag", 0.95))
    best = min(forms, key=lambda h: h.left)
    state.by_names = lambda: {FRICTION: best}
    state.tried += forms
    assert part_of(None, None, state) is forms[chosen]


@pytest.fixture(scope="module")
def found():
    """Dry friction, beside a law that nobody knows: a sine of the angle that fades with the rate."""
    hidden = oscillator(lambda q, v: -1500.0 * np.sign(v) - 1500.0 * np.sin(3.0 * q) * np.exp(-((v / 40.0) ** 2)), noise=0.01)
    return find(*hidden).verdict


def test_friction_beside_an_unknown_law_has_its_name_and_its_size(found):
    assert found["verdict"] == "unknown"
    first = found["set"][0]
    assert first["unknown"]
    (effect,) = first["effects"]
    assert effect["effect"] == "coulomb_friction"
    assert effect["parameters"]["level"]["joint"]["value"] == pytest.approx(1500.0, rel=0.1)


def test_what_is_left_is_told_beside_it_as_a_table(found):
    assert [e["effect"] for e in found["added"]] == ["coulomb_friction", "force_table"]
    gap = found["gap"]
    assert gap["after"] ** 2 - 1.0 < 0.1 * (gap["retuned"] ** 2 - 1.0)
