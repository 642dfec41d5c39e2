"""The compiled machine passes over laws that no lane of a block uses, and nobody can tell from the readings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics.bank_stages import USUAL
from hamr_dynamics.effects.bank import Bank
from hamr_dynamics.machine import leg_machine
from hamr_dynamics.machine_kernel import LANES, final_states, simulate, source, used_laws
from hamr_dynamics.plant import plant

MACHINES = {leg: leg_machine(plant("simple"), leg, gravity=value("robot.gravity")) for leg in ("fl", "rl", "fr", "rr")}
LEG = MACHINES["fl"]
PLACES = [(name, form, place) for name, form in Bank(2).forms for place in LEG.places(form)]
DRIVES = np.random.default_rng(0).normal(0, 40, (400, 2)).clip(-112, 112)

effect = st.tuples(st.sampled_from(range(len(PLACES))), st.floats(0.1, 3.0))


def rows_of(lanes: list[list[tuple[int, float]]]) -> np.ndarray:
    """(K, rows): each lane's effects, of so many times their usual sizes."""
    rows = np.tile(LEG.neutral(USUAL), (len(lanes), 1))
    for lane, effects in zip(rows, lanes, strict=True):
        for which, by in effects:
            name, form, place = PLACES[which]
            for size in form.sizes:
                row = LEG.parameter_rows.index(f"{name}.{form.name}.{size.name}.{place}")
                lane[row] = by * size.typical * USUAL.of(size.dimension)
    return rows


def run(rows: np.ndarray, **more) -> np.ndarray:
    return simulate(LEG, DRIVES, rows, step=SERVO_MS, substeps=2, mean=2, **more)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(effect, max_size=3), min_size=1, max_size=2 * LANES + 3))
def test_laws_of_size_zero_are_passed_over_unseen(lanes):
    """Bit for bit, whatever acts in which lanes."""
    rows = rows_of(lanes)
    assert np.array_equal(run(rows), run(rows, every_law=True))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.lists(effect, min_size=1, max_size=3), min_size=2, max_size=LANES))
def test_a_lane_runs_the_same_alone_and_among_others(lanes):
    rows = rows_of(lanes)
    together = run(rows)
    for i in (0, len(lanes) - 1):
        assert np.array_equal(run(rows[[i]])[0], together[i])


def test_drives_that_end_too_early_are_not_read_on():
    rows = rows_of([[]])
    assert simulate(LEG, DRIVES, rows, step=SERVO_MS, substeps=1, first=np.array([100]), samples=300).shape == (1, 300, 4)
    with pytest.raises(ValueError, match="end after 400 steps, a run after 401"):
        simulate(LEG, DRIVES, rows, step=SERVO_MS, substeps=1, first=np.array([101]), samples=300)


@pytest.mark.parametrize("channels", [(0, 1), (2, 0), (3,), ()])
def test_channels_are_read_as_among_all(channels):
    rows = rows_of([[(k, 1.0)] for k in range(LANES + 3)])
    assert np.array_equal(run(rows, channels=channels), run(rows)[:, :, list(channels)])


@pytest.mark.parametrize("which", range(len(PLACES)), ids=[f"{name}.{form.name}.{place}" for name, form, place in PLACES])
def test_each_law_is_used_where_one_size_is_not_zero(which):
    """By any of its sizes, in any lane, in its block alone; shapes and changes use none."""
    name, form, place = PLACES[which]
    neutral = np.repeat(LEG.neutral(USUAL)[None, :, None], LANES, 2)
    for i, size in enumerate(form.sizes):
        param = np.repeat(neutral, 2, 0)
        param[1, LEG.parameter_rows.index(f"{name}.{form.name}.{size.name}.{place}"), i % LANES] = -1e-30
        used = used_laws(LEG, param.reshape(2, -1))
        assert used.sum(1).tolist() == [0, 1]
    shaped = neutral.copy()
    sizes = {f"{n}.{f.name}.{size.name}.{p}" for n, f, p in PLACES for size in f.sizes}
    shaped[:, [row not in sizes for row in LEG.parameter_rows]] = 1.0
    assert not used_laws(LEG, shaped.reshape(1, -1)).any()


def test_what_an_unused_law_remembers_stays():
    start = np.zeros((2, len(LEG.state_rows)))
    creep, play = (LEG.state_rows.index(f"{name}.0") for name in ("piezo_creep.kelvin_voigt.z0", "piezo_hysteresis.plays.z0"))
    start[:, [creep, play]] = 3.0
    rows = rows_of([[], [(PLACES.index(next(x for x in PLACES if x[0] == "piezo_creep")), 1.0)]])
    end = final_states(LEG, DRIVES, rows, step=SERVO_MS, steps=100, first=np.zeros(2, int), start=start)
    assert np.array_equal(end[:, play], [3.0, 3.0])
    assert np.abs(end[:, creep] - 3.0).min() > 0.01


def test_equal_machines_share_a_kernel():
    """Left and right legs have the same numbers in their frames, front and rear ones do not."""
    text = {leg: source(machine) for leg, machine in MACHINES.items()}
    assert text["fl"] == text["fr"]
    assert text["rl"] == text["rr"]
    assert text["fl"] != text["rl"]
