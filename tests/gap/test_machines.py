"""Machines of one's own: tables of named columns, runs in pieces, several stretches, and a cart whose friction is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hamr_description.errors import BagError, ConfigError, HamrError
from hamr_dynamics import machine_kernel
from hamr_dynamics.machine import Machine, Terms, linear_machine
from hamr_dynamics.stops import stop_force
from hamr_gap.data.columns import UNITS, record_of
from hamr_gap.data.read_table import read_columns
from hamr_gap.data.readings import noise_of
from hamr_gap.data.record import Record, joined
from hamr_gap.fitting.model import EDGE, Model
from hamr_gap.fitting.parameters import Candidate, changes, effect_parameters
from hamr_gap.fitting.pieces import moving
from hamr_gap.fitting.scales import scales_of
from hamr_gap.judging.weigh import weigh
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.search import search
from hamr_gap.plants import load

UNIT = {"F": "N", "Q": "m", "T": "s", "U": "N"}
CART = linear_machine("test_cart", inertia=2.0, damping=3.0, joint="cart", units=UNIT)
SPRING = linear_machine("test_spring", inertia=1.0, damping=20.0, stiffness=900.0, joint="mass", units=UNIT)
FINITE = st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: float(f"{x:.9g}"))


def noise(n: int, seed: int, width: int = 9) -> np.ndarray:
    x = np.convolve(np.random.default_rng(seed).normal(0, 1, n + width), np.hanning(width), "valid")[:n]
    return 4.0 * x[:, None]


def sliding(n: int, seed: int, *, friction: float, step: float = 1e-3) -> Record:
    """A cart with dry friction, by small explicit steps that know nothing of the library."""
    force, q, v, seen, fine = noise(n, seed, 81), 0.0, 0.0, np.empty((n, 1)), 10
    for i in range(n):
        seen[i] = q
        for _ in range(fine):
            before = v
            v += step / fine * (force[i, 0] - 3.0 * v - friction * np.tanh(v / 2e-3)) / 2.0
            q += step / fine * 0.5 * (before + v)
    return Record(force, seen + np.random.default_rng(seed).normal(0, 1e-4, seen.shape), step, ("cart",), held=True, rest=False)


@settings(max_examples=25)
@given(st.lists(st.tuples(FINITE, FINITE), min_size=3, max_size=20), st.sampled_from(["csv", "npz"]))
def test_a_table_gives_back_what_was_written(tmp_path_factory, rows, kind):
    drive, cart = np.array(rows).T
    path = tmp_path_factory.mktemp("table") / f"a.{kind}"
    time = 0.25 * np.arange(len(rows))
    if kind == "npz":
        np.savez(path, **{"time [ms]": time, "drive": drive, "cart [mm]": cart})
    else:
        lines = [",".join(map(repr, map(float, row))) for row in zip(time, drive, cart, strict=True)]
        path.write_text('"time [ms]", drive ,"cart [mm]",\n' + ",\n".join(lines) + ",\n")
    record = record_of(CART, path)
    assert np.array_equal(record.drives[:, 0], drive)
    assert np.allclose(record.readings[:, 0], 1e-3 * cart, rtol=1e-15)
    assert record.step == pytest.approx(2.5e-4, rel=1e-12) and not record.breaks and not record.rest


def test_names_can_be_mapped_and_time_can_be_a_number(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("V1,V2\n1,10\n2,20\n3,\n")
    record = record_of(CART, path, {"time": 0.01, "drive": "V1 [mN]", "cart": "V2"})
    assert np.allclose(record.drives[:, 0], [1e-3, 2e-3, 3e-3]) and record.step == 0.01
    assert np.array_equal(record.readings[:, 0], [10.0, 20.0, np.nan], equal_nan=True)


def test_a_jump_of_time_begins_a_new_stretch(tmp_path):
    time = np.r_[np.arange(5), 20 + np.arange(4), np.arange(3)] * 0.1
    np.savez(tmp_path / "a.npz", time=time, drive=time, cart=time)
    record = record_of(CART, tmp_path / "a.npz")
    assert record.breaks == (5, 9) and record.step == pytest.approx(0.1)
    assert joined([record, record]).breaks == (5, 9, 12, 17, 21)
    assert joined([record, record]).cut(6, 20).breaks == (3, 6, 11)


@pytest.mark.parametrize(
    ("text", "columns", "said"),
    [
        ("1,2,3\n4,5,6\n", {}, "begins with numbers"),
        ("time,time,cart\n1,2,3\n", {}, "header"),
        ("time,drive,cart\n0,1,2\n1,x,2\n2,1,2\n", {}, "'x' in data row 2"),
        ("time,drive,cart\n0,1\n", {}, "2 cells in data row 1"),
        ("time,force,cart\n0,1,2\n1,1,2\n2,1,2\n", {}, "no column 'drive'"),
        ("time,drive\n0,1\n1,1\n2,1\n", {}, "no column for the sensor cart"),
        ("time,drive [parsec],cart\n0,1,2\n1,1,2\n2,1,2\n", {}, "'parsec'"),
        ("time,drive [mm],cart\n0,1,2\n1,1,2\n2,1,2\n", {}, "cannot be made N"),
        ("time,drive,cart\n0,1,2\n1,1,2\n2.3,1,2\n3.3,1,2\n4.3,1,2\n", {}, "uneven by 30 %"),
        ("time,drive,cart\n2,1,2\n1,1,2\n0,1,2\n", {}, "do not rise"),
        ("time,drive,cart\n0,,2\n1,1,2\n2,1,2\n", {}, "drive is NaN"),
        ("time,drive,cart\n0,1,2\n1,1,2\n2,1,2\n", {"wheel": "cart"}, "'wheel'"),
    ],
)
def test_bad_tables_are_one_sentence(tmp_path, text, columns, said):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(HamrError) as error:
        record_of(CART, path, columns)
    assert said in str(error.value) and str(error.value).count(". ") == 0 and "\n" not in str(error.value)


def test_tables_run_no_code_and_must_exist(tmp_path):
    np.savez(tmp_path / "a.npz", time=np.array([{"a": 1}], dtype=object))
    for path, said in ((tmp_path / "a.npz", "cannot be read"), (tmp_path / "b.csv", "no table"), (tmp_path, "no table")):
        with pytest.raises(BagError, match=said):
            read_columns(path)


@pytest.mark.parametrize(
    ("text", "name", "said"),
    [("x = 1\n", "cart", "no function"), ("def cart(): return 3\n", "cart", "returns a int"),
     ("def cart(): 1 / 0\n", "cart", "ZeroDivision"), ("import nothing_such\n", "cart", "nothing_such"), ("", "not a name", "is no plant")],
)  # fmt: skip
def test_bad_plants_are_one_sentence(tmp_path, text, name, said):
    (tmp_path / "p.py").write_text(text)
    with pytest.raises(ConfigError, match=said):
        load(f"{tmp_path}/p.py:{name}")


def test_units_are_those_of_si():
    assert all(unit in UNITS and UNITS[unit][0] == 1.0 for _, unit in UNITS.values())


def _model(machine, record, **more) -> Model:
    return Model(machine, record, 2, 1, scales_of(machine, record), **more)


@pytest.mark.parametrize(
    "effect", ["coulomb_friction.sign", "cubic_stiffness.cubic", "drive_lag.first_order", "coulomb_friction.presliding"]
)
def test_pieces_from_true_states_are_one_long_run(effect):
    """The long run is the compiled loop's own; effects with states of their own agree as far as a run-in brings them there."""
    n, step, (name, form) = 3000, 1e-3, effect.split(".")
    record = Record(noise(n, 1), np.cumsum(noise(n, 2), axis=0), step, ("cart",), held=True, rest=False)
    model = _model(CART, record)
    free = effect_parameters([Candidate(name, form, (0,))], model.scales)
    rows = model.rows(free, np.array([[f.center or 0.5 for f in free], [0.8 * f.center or 0.2 for f in free]]))
    exact = {"step": step / 2, "first": np.zeros(2, int), "start": np.zeros((2, len(CART.state_rows)))}
    whole = machine_kernel.simulate(CART, model.drives, rows, step=step / 2, substeps=2)
    states = lambda at: machine_kernel.final_states(CART, model.drives, rows, steps=int(2 * at), **exact)[:, :2]  # noqa: E731
    pieces = model.pieces
    assert len(pieces) >= 8
    for lane in (0, 1):
        before, start = (np.array([states(at)[lane] for at in where]) for where in (pieces.first - pieces.lead, pieces.first))
        model.pieces = replace(pieces, before=before, start=start)
        found, begin = model.run_rows(rows[[lane]])[0], pieces.first[0]
        close = 1e-9 if form in ("sign", "cubic") else 1.5e-2
        assert np.abs(found[begin:] - whole[lane, begin:]).max() < close * np.ptp(whole[lane])


def hitting(*, stepped: bool) -> Machine:
    """A mass on a spring between stops."""

    def terms(q, v_mid, v, u, step=None):
        stop = stop_force(q[0], v[0], -0.004, 0.004, 2e4, 5.0, step)
        force = u[0] - 900.0 * q[0] - 20.0 * v[0] + stop.force
        return Terms((1.0,), (0.0,), (force,), (900.0 + stop.stiffness,), (20.0 + stop.damping,), (u[0],))

    si = dict.fromkeys("FQTU", 1.0)
    return Machine(f"test_hitting_{stepped}", ("mass",), ("mass",), terms, lambda q, slip: (q[0],), UNIT, si, stepped=stepped)


@pytest.mark.parametrize("stepped", [True, False])
def test_what_is_hit_does_not_jump_for_a_machine_that_knows_the_step(stepped):
    """A gain that grows evenly moves the run evenly; whole steps of touching jump with the step in which the mass hits."""
    machine = hitting(stepped=stepped)
    model = _model(machine, Record(noise(3000, 3), noise(3000, 4), 1e-3, ("mass",), held=True))
    (gain,) = (f for f in changes(machine, model.scales, (True,)) if f.row == "change.gain.0")
    runs = model.runs((gain,), np.linspace(0.0, 3e-3, 65)[:, None])
    assert np.mean(np.abs(runs[0]) > 0.004) > 0.02
    moved = np.std(np.diff(runs, axis=0), axis=(1, 2))
    jump = moved.max() / np.median(moved)
    assert jump < 1.2 if stepped else jump > 3.0


def test_a_machine_that_forgets_runs_freely_and_as_ever():
    record = Record(noise(3000, 3), noise(3000, 4), 1e-3, ("mass",))
    model = _model(SPRING, record)
    assert model.pieces is None
    rows = np.tile(model.neutral, (2, 1))
    assert np.array_equal(model.run_rows(rows), machine_kernel.simulate(SPRING, model.drives, rows, step=5e-4, substeps=2))


def test_stretches_of_a_machine_that_forgets_start_anew():
    one = Record(noise(2000, 3), noise(2000, 4), 1e-3, ("mass",))
    model = _model(SPRING, joined([one, one]))
    run = model.run_rows(model.neutral[None])[0]
    assert np.array_equal(run[:2000], run[2000:])
    assert np.array_equal(run[:2000], _model(SPRING, one).run_rows(model.neutral[None])[0])


@pytest.mark.parametrize("delay", [-0.0035, 0.0, 0.0042])
@pytest.mark.parametrize("mean", [1, 3])
def test_stretches_read_late_or_averaged_are_those_of_runs_of_their_own(delay, mean):
    """Also where a reading of several samples would lie across the break; readings about it serve nothing."""
    parts = [Record(noise(n, n), noise(n, n + 1), 1e-3, ("mass",)) for n in (2000, 1500)]
    both = joined(parts)
    model = Model(SPRING, both, 2, mean, scales_of(SPRING, both), delay=delay)
    run = model.run_rows(model.neutral[None])[0]
    own = [_model(SPRING, part, delay=delay).run_rows(model.neutral[None])[0] for part in parts]
    begin = -2000 % mean  # samples of the second that lie in no reading
    wanted = [x[: len(x) // mean * mean].reshape(-1, mean, 1).mean(1) for x in (own[0], own[1][begin:])]
    served = np.isfinite(model.target[:, 0])
    wanted.insert(1, np.zeros((int(begin > 0), 1)))
    assert np.allclose(run[served], np.concatenate(wanted)[: len(run)][served], rtol=0, atol=1e-12)
    assert served.sum() > len(served) - 2 * EDGE - 6
    at = -(-2000 // mean)
    assert not served[at - EDGE : at + EDGE].any()


def test_a_start_that_nobody_measured_is_no_loss_where_it_is_forgotten():
    one = Record(noise(2000, 3), noise(2000, 4), 1e-3, ("mass",), rest=False)
    gap = np.where(np.arange(2000)[:, None] < 50, np.nan, one.readings)
    assert len(_model(SPRING, joined([one, replace(one, readings=gap)])).pieces) == 2


@settings(max_examples=20)
@given(st.tuples(*[st.floats(-3, 3)] * 4))
def test_motion_of_a_cubic_is_exact(c):
    t = np.arange(400) * 0.01
    record = Record(noise(400, 1), np.polyval(c, t)[:, None], 0.01, ("cart",), rest=False)
    at = np.array([0, 57, 399])
    found = moving(CART, record, at)
    assert np.allclose(found, np.stack([np.polyval(c, t[at]), np.polyval(np.polyder(c), t[at])], 1), atol=1e-6)


def test_motion_is_as_good_as_the_noise_allows():
    """A rate from two samples would have an error of 0.14; a window as wide as the signal bears does twenty times better."""
    t = np.arange(4000) * 1e-3
    random = np.random.default_rng(5)
    record = Record(noise(4000, 1), (np.sin(2 * t) + random.normal(0, 1e-4, 4000))[:, None], 1e-3, ("cart",), rest=False)
    at = np.arange(300, 3700, 100)
    q, v = moving(CART, record, at).T
    assert np.sqrt(np.mean((q - np.sin(2 * t[at])) ** 2)) < 5e-5
    assert np.sqrt(np.mean((v - 2 * np.cos(2 * t[at])) ** 2)) < 7e-3


def test_a_sensor_with_steps_is_not_free_of_noise():
    t = np.linspace(0, 3, 2000)
    rounded = np.round(np.maximum(np.sin(t), 0.9) / 0.01) * 0.01  # rests on one step for a long time
    assert noise_of(rounded[:, None])[0] == pytest.approx(0.01 / np.sqrt(12), rel=1e-6)
    assert noise_of(np.sin(t)[:, None])[0] < 1e-9


def test_what_mostly_stands_still_is_judged_by_where_it_moves():
    """Coarse readings, resampled, are equal to the bit at rest: by that alone they would be free of noise."""
    t = np.linspace(0.0, 8.0, 4000)
    moving = np.where(t < 2.0, np.sin(2.0 * t), np.sin(4.0))
    assert noise_of((moving + np.random.default_rng(0).normal(0.0, 1e-3, t.size) * (t < 2.0))[:, None])[0] == pytest.approx(1e-3, rel=0.2)


def test_dry_friction_of_a_cart_is_found_from_a_wrong_mass():
    guess = linear_machine("test_cart", inertia=2.4, damping=2.5, joint="cart", units=UNIT)
    prepared = prepare(guess, sliding(16000, 7, friction=1.5))
    assert prepared.weighed.model.pieces is not None
    state = search(prepared.weighed, prepared.judged, prepared.base)
    first = weigh(state)[0].hypothesis
    assert [c.effect for c in first.effects] == ["coulomb_friction"]
    levels = [x * f.scale for f, x in zip(first.fit.free, first.fit.x, strict=True) if ".level." in f.row]
    assert levels == [pytest.approx(1.5, rel=0.03)]
