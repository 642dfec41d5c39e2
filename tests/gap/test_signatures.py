"""Pages of the library: all there, what they say is accepted, and what they show is the physics they claim."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from hamr_description.errors import ConfigError
from hamr_dynamics.effects.effects_file import read
from hamr_dynamics.effects.library import library
from hamr_gap.legs import machine_of
from hamr_gap.signatures.__main__ import write
from hamr_gap.signatures.figure import Panel
from hamr_gap.signatures.page import index
from hamr_gap.signatures.shown import SIZES, experiments, panels

DOCS = Path(__file__).parents[2] / "docs" / "effects"
REST = machine_of("simple", "fl").at_rest
STIFFNESS, DAMPING = 1e-3 * REST.stiffness[0], 1e-6 * REST.damping[0]  # SI
LARGEST = 25_000  # bytes of a page or picture


def shown(effect: str, experiment: str) -> Panel:
    return panels(library()[effect])[experiments(library()[effect]).index(experiment)]


def curve(panel: Panel, state: str) -> tuple[np.ndarray, np.ndarray]:
    """The first run of a state."""
    first = next(c for c in panel.curves if c.state == state)
    return first.x, first.y


def test_every_effect_has_a_small_page_and_picture_and_no_other_has():
    names = {f"{name}.{kind}" for name in library() for kind in ("md", "svg")} | {"README.md"}
    assert {path.name for path in DOCS.iterdir()} == names
    assert max(path.stat().st_size for path in DOCS.iterdir()) < LARGEST
    assert (DOCS / "README.md").read_text() == index()


@pytest.mark.parametrize("name", library())
def test_a_page_says_what_the_library_has_and_its_file_is_accepted(name, tmp_path):
    text = (DOCS / f"{name}.md").read_text()
    (snippet,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    (tmp_path / "effects.yaml").write_text(snippet)
    (placed,) = read(tmp_path / "effects.yaml").effects
    assert placed.effect == name
    assert any(placed.parameters[size.name] for size in placed.law.sizes)
    effect = library()[name]
    assert all(words in text for words in (effect.summary, effect.source, effect.experiment, *(f"### `{f.name}`" for f in effect.forms)))
    for target in re.findall(r"\]\(([^)]*)\)", text):
        assert (DOCS / target).exists()


@pytest.mark.parametrize("name", ["coulomb_friction", "sensor_quantisation"])
def test_written_again_it_is_the_same_to_the_byte(name, tmp_path):
    write(name, tmp_path)
    for kind in ("md", "svg"):
        assert (tmp_path / f"{name}.{kind}").read_bytes() == (DOCS / f"{name}.{kind}").read_bytes()


def test_an_unknown_effect_is_refused_in_one_sentence(tmp_path):
    with pytest.raises(ConfigError, match="no effect 'stiction'"):
        write("stiction", tmp_path)


def test_the_loop_of_dry_friction_is_twice_level_over_stiffness_wide():
    drive, angle = curve(shown("coulomb_friction", "triangle"), "with")
    down = (drive < np.roll(drive, 1)) & (np.abs(drive) < 30)
    up = (drive > np.roll(drive, 1)) & (np.abs(drive) < 30) & (np.arange(len(drive)) > len(drive) / 2)
    width = np.interp(0.0, drive[down][::-1], angle[down][::-1]) - np.interp(0.0, drive[up], angle[up])
    assert width == pytest.approx(2.0 * SIZES["coulomb_friction"]["level"] / STIFFNESS, rel=0.02)


@pytest.mark.parametrize("name", ["drive_delay", "sensor_latency"])
def test_a_delay_adds_phase_in_proportion_to_frequency_and_no_gain(name):
    panel = shown(name, "phase")
    (hertz, without), (_, late) = curve(panel, "without"), curve(panel, "with")
    angle, turn = 2 * np.pi * hertz * SIZES[name]["delay"], np.unwrap(late - without)
    turn -= 2 * np.pi * np.round(turn[0] / (2 * np.pi))
    assert np.all(np.abs(turn + angle) < angle**5 / 720 + 2e-3)  # what a Pade approximation of order two is off by
    gain = shown(name, "gain")
    assert curve(gain, "with")[1] == pytest.approx(curve(gain, "without")[1], rel=0.01)


def test_a_cubic_spring_rests_where_its_force_says():
    panel = shown("cubic_stiffness", "triangle")
    (_, angle), (_, linear) = curve(panel, "with"), curve(panel, "without")
    assert STIFFNESS * angle + SIZES["cubic_stiffness"]["cubic"] * angle**3 == pytest.approx(
        STIFFNESS * linear, abs=0.02 * STIFFNESS * linear.max()
    )
    assert np.abs(linear).max() > 1.2 * np.abs(angle).max()


def test_viscous_loss_grows_with_frequency_and_structural_loss_does_not():
    panel = shown("structural_damping", "loss")
    (hertz, viscous), (_, both) = curve(panel, "without"), curve(panel, "with")
    assert 1e-6 * viscous == pytest.approx(2 * np.pi * hertz * DAMPING, rel=0.02)
    assert 1e-6 * (both - viscous) == pytest.approx(SIZES["structural_damping"]["loss"], rel=0.1)
