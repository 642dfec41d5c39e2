"""What would decide between two names, and whether a second run decides as was said."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from oscillator import MACHINE, STEP, measured, oscillator

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record, joined
from hamr_gap.experiments import experiment
from hamr_gap.experiments.apart import WITHIN, Apart, Follower, after, asked, served
from hamr_gap.experiments.excite import NOISES, signals
from hamr_gap.experiments.experiment import DECISIVE, TRIED_S, Proposal, propose
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.fitting.roles import CYCLE
from hamr_gap.judging.analyse import analyse
from hamr_gap.judging.told_apart import by_all
from hamr_gap.judging.weigh import SHARPNESS, floor_of, least_told
from hamr_gap.naming.hypothesis import BLOCKS, Hypothesis, refine, residual, starts
from hamr_gap.naming.prepare import Prepared, prepare
from hamr_gap.naming.screen import screen
from hamr_gap.naming.tried import FLOOR_ERROR, Search


def friction(q: float, v: float) -> float:
    return -300.0 * np.tanh(v / 0.5)


def hardening(q: float, v: float) -> float:
    return -60.0 * q**3


def rivals(record: Record) -> tuple[Prepared, list[Hypothesis]]:
    """A spring that hardens and a drive that saturates, fitted to a record."""
    prepared = prepare(MACHINE, record)
    both = [Candidate(name, library()[name].forms[0].name, (0,)) for name in ("cubic_stiffness", "drive_saturation")]
    amplitude = float(np.sqrt(np.nanmean(residual(prepared.weighed, prepared.base.fit) ** 2)))
    seen = screen(prepared.weighed, prepared.base.fit, both, amplitude=amplitude)
    found = [starts(prepared.weighed, prepared.base.fit, seen, [((c,), seen.best(c)[0])]) for c in both]
    return prepared, [refine(prepared.weighed, prepared.judged, start) for (start,) in found]


def slowly(seconds: float) -> np.ndarray:
    """(n,) drives to 2 Hz, far below the machine's 12 Hz: what hardens moves as if it were driven less."""
    random, n = np.random.default_rng(5), int(seconds / STEP)
    spectrum = random.standard_normal((n // 2 + 1, 2)) @ (1.0, 1j) * (np.fft.rfftfreq(n, STEP) < 2.0)
    drive = np.fft.irfft(spectrum, n)
    return drive * np.minimum(np.arange(n) / 500.0, 1.0) * 8000.0 / drive.std()


@pytest.fixture(scope="module")
def proposed() -> tuple[Record, Prepared, list[Hypothesis], Proposal]:
    """A spring that hardens, driven slowly: a drive that saturates explains the record as well, until it is driven near its resonance."""
    record = measured(slowly(12.0), hardening, np.random.default_rng(6), 0.03)
    prepared, fits = rivals(record)
    return record, prepared, fits, propose(prepared, [[h] for h in fits], noise=1.0)


def test_signals_of_an_experiment_stay_within_the_drive_and_start_gently():
    machine = linear_machine("test_signals", inertia=1.0, stiffness=100.0)
    for name, x in signals(machine, 0.01, 3000).items():
        assert x.shape == (3000, 1), name
        assert np.abs(x).max() <= 1.0 + 1e-12, name
        assert np.abs(x[:3]).max() < 0.05, name
        assert x.std() > 0.05, name
    fast = np.abs(np.fft.rfft(signals(machine, 0.01, 3000)["fast noise"][:, 0])) ** 2
    assert fast[np.fft.rfftfreq(3000, 0.01) < 10.0 / (2 * np.pi)].sum() < 0.02 * fast.sum()  # nothing slower than the machine


def test_noise_has_nothing_beyond_its_band_nor_high_peaks():
    """Cut off at the largest drive it would have, between samples too, where nobody knows of it."""
    machine = linear_machine("test_signals", inertia=1.0, stiffness=100.0)
    found, step = signals(machine, 0.005, 12_000), 0.005
    pace = 10.0 / (2.0 * np.pi)
    for name, (level, _, fastest) in NOISES.items():
        x = found[name][2000:]  # it has begun
        power = np.abs(np.fft.rfft(x[:, 0] * np.hanning(len(x)))) ** 2
        assert power[np.fft.rfftfreq(len(x), step) > 1.02 * fastest * pace].sum() < 1e-6 * power.sum()
        assert x.std() == pytest.approx(level, rel=0.05)
        assert np.abs(x).max() < 2.2 * x.std()


def test_noise_is_no_faster_than_samples_can_be():
    machine = linear_machine("test_signals", inertia=1.0, stiffness=100.0)
    for x in signals(machine, 0.3, 3000).values():  # two samples in a period of the machine
        assert np.isfinite(x).all()
        assert x.std() > 0.05


def test_an_experiment_is_proposed_that_tells_rivals_apart(proposed):
    record, prepared, fits, proposal = proposed
    assert proposal.signal
    assert proposal.odds[proposal.signal] > DECISIVE
    assert proposal.d_prime[proposal.signal] > 5.0
    assert np.abs(proposal.drives).max() <= np.abs(record.drives).max() * (1 + 1e-12)
    asked = replace(record, drives=proposal.drives, readings=np.zeros((len(proposal.drives), 1)), rest=True)
    model = replace(prepared.weighed.model, record=asked)
    for h in fits:  # no further than what was seen: there may be an end stop
        assert np.abs(model.runs(h.fit.free, h.fit.x)).max() <= 1.01 * WITHIN * np.nanmax(np.abs(record.readings))


def test_nothing_tells_a_name_from_itself(proposed):
    _, prepared, fits, _ = proposed
    same = propose(prepared, [fits[:1], fits[:1]], noise=1.0)
    assert same.signal == ""
    assert "no drive signal" in same.as_dict(("a", "a"))["sentence"]
    assert max(same.odds.values()) < 1e-6


@pytest.mark.parametrize(
    ("shown", "asked_for"), [(Apart(0.0, 0.0), False), (Apart(0.025, 0.025, 1.0), False), (Apart(0.025, 0.025, 9.0), True)]
)
def test_a_run_is_asked_for_if_a_refit_says_that_it_decides_throughout(proposed, monkeypatch, shown, asked_for):
    """Whatever the linear picture says: of what is less than the error of the noise, and not seen throughout, nothing is believed."""
    _, prepared, fits, proposal = proposed
    monkeypatch.setattr(Follower, "refitted", lambda *_: shown)
    found = propose(prepared, [[h] for h in fits], noise=1.0)
    assert max(proposal.odds.values()) > DECISIVE
    assert bool(found.signal) == asked_for


def made(choice: experiment._Choice, left: float, seconds: float) -> float:
    """Log odds that a run makes of which the wrong name leaves so much, and the re-tune what it leaves of the record."""
    return choice._odds(experiment._Pair(None, (), Apart(choice._before, choice._before), Apart(0.0, left)), seconds)


def test_what_a_run_shows_is_held_against_what_all_readings_can_tell(proposed):
    """As much as nothing tells apart, of all that are fitted and judged, makes log 8: a factor of two in what is left, cubed."""
    _, prepared, fits, _ = proposed
    choice = experiment._Choice(prepared, [fits[:1], fits[1:]], 1.0, 0)
    told = 2 * (prepared.judged.sum() + prepared.weighed.chosen.sum())  # the run is as long as the record
    left = 2.0 * least_told(choice._before, told) * choice._before
    assert made(choice, left, prepared.weighed.model.record.span) == pytest.approx(SHARPNESS * np.log(2.0), rel=1e-3)


def test_what_the_right_name_leaves_within_the_error_of_the_noise_is_no_law_of_a_long_run(proposed):
    """More readings have that error to share, and it is what the record left beyond it."""
    _, prepared, fits, _ = proposed
    least, seconds = min(by_all(prepared.weighed, prepared.judged, h).left for h in fits), 9.0 * prepared.weighed.model.record.span
    none, little = (
        made(experiment._Choice(prepared, [fits[:1], fits[1:]], (least - known) / (1.0 + FLOOR_ERROR), 0), 0.005, seconds)
        for known in (0.0, 0.02)
    )
    assert little == pytest.approx(none, rel=0.02)


def test_of_names_that_nothing_tells_apart_the_first_two_that_something_does_are_decided(proposed):
    _, prepared, fits, proposal = proposed
    three = propose(prepared, [fits[:1], fits[1:], fits[1:]], noise=1.0)
    assert (three.names, three.signal, three.seconds) == (2, proposal.signal, proposal.seconds)
    assert "between a and b." in three.as_dict(("a", "b", "c"))["sentence"]


def test_forms_of_a_name_are_the_best_of_each_that_do_about_as_well(proposed):
    _, prepared, fits, _ = proposed
    forms = [Candidate("cubic_stiffness", form, (0,)) for form in ("cubic", "mixed", "quintic", "other")]
    left = ((1, 1.02), (1, 1.01), (2, 1.1), (0, 1.0), (0, 1.005), (3, 1.029))
    tried = [replace(fits[0], effects=(forms[k],), left=x) for k, x in left]
    state = Search(prepared.weighed, prepared.base, None, 100, [*tried, replace(fits[1], left=0.9)])
    assert state.forms_of(tried[4]) == [tried[4], tried[1], tried[5]]
    assert replace(state, tried=tried[1:3]).forms_of(tried[4]) == [tried[4], tried[1]]


def test_a_record_that_begins_in_motion_is_not_followed_by_the_run(proposed):
    record, prepared, _, _ = proposed
    moving = prepare(MACHINE, replace(record, rest=False))
    lengths = [len(after(p, asked(record, np.zeros((4000, 1)))).model.target) for p in (moving, prepared)]
    assert lengths == [4000, 4000 + len(record)]


def test_both_runs_together_decide_as_was_said(proposed):
    record, _, fits, proposal = proposed
    assert fits[1].left < 1.01 * fits[0].left  # nothing to choose from the record alone
    clean = measured(proposal.drives[:, 0], hardening, np.random.default_rng(8), 0.0).readings
    again = measured(proposal.drives[:, 0], hardening, np.random.default_rng(8), 0.03 * record.readings.std() / clean.std())
    prepared, (right, wrong) = rivals(joined([record, again]))
    assert right.left < 1.05
    floor = floor_of(1.0, (right, wrong))
    gap = prepared.base.left - floor
    least = least_told(gap, prepared.judged.sum())
    left, rival = (max(h.left - floor, 0.0) / gap for h in (right, wrong))
    assert SHARPNESS * np.log((rival + least) / (left + least)) > DECISIVE


@pytest.mark.parametrize("right", [0, 1])
def test_what_is_foreseen_linearly_is_what_a_refit_leaves_where_names_differ_little(proposed, right):
    _, prepared, fits, proposal = proposed
    weighed = after(prepared, asked(prepared.weighed.model.record, 0.5 * proposal.drives))
    own = len(weighed.model.target) - len(proposal.drives)
    both = [Follower(weighed, own, h) for h in fits]
    foreseen, refitted = (getattr(both[1 - right], way)(both[right].run) for way in ("foreseen", "refitted"))
    assert refitted.run == pytest.approx(foreseen.run, rel=0.3)
    assert both[right].refitted(both[right].run).run < 1e-6  # a hypothesis follows itself


def test_what_a_run_shows_is_what_neither_parameters_nor_sensors_follow(proposed):
    """A bias follows readings that are higher all the time; nothing follows what changes sign from one to the next."""
    _, prepared, fits, _ = proposed
    weighed = after(prepared, asked(prepared.weighed.model.record, np.zeros((4000, 1))))
    own = len(weighed.model.target) - 4000
    follower = Follower(weighed, own, fits[0])
    alternating = np.r_[np.zeros(own), np.tile([1.0, -1.0], 2000)][:, None] * weighed.sigma
    assert follower.foreseen(follower.run + weighed.sigma).run < 1e-6
    assert follower.foreseen(follower.run + alternating).run == pytest.approx(1.0, abs=1e-3)
    assert follower.foreseen(follower.run + alternating).record < 1e-3


def test_a_run_is_foreseen_on_the_readings_that_its_verdict_will_judge(proposed):
    """What it shows elsewhere, nobody will see; and the shortest run that is asked for has all its turns."""
    _, prepared, fits, _ = proposed
    weighed = after(prepared, asked(prepared.weighed.model.record, np.zeros((int(TRIED_S / STEP), 1))))
    own = len(prepared.weighed.model.target)
    fitted, judged = parts = served(weighed)
    held_out = judged & ~fitted
    assert (judged[fitted]).all()
    assert np.count_nonzero(np.diff(held_out[own:, 0].astype(int)) == 1) == CYCLE.count("select")
    follower = Follower(weighed, own, fits[0], parts)
    shown = np.tile([1.0, -1.0], len(judged) // 2)[:, None] * weighed.sigma
    share = held_out[own:].sum() / judged[own:].sum()
    assert follower.refitted(follower.run + shown * judged).run == pytest.approx(1.0, abs=1e-3)
    assert follower.refitted(follower.run + weighed.sigma * held_out).run == pytest.approx(share, abs=1e-3)  # no bias follows it
    assert follower.refitted(follower.run + shown * ~judged).run < 1e-6
    half = judged & (np.cumsum(judged[:, :1], axis=0) < 0.5 * judged.sum())  # of as many blocks as names are told apart by
    assert follower.refitted(follower.run + shown * half).throughout == pytest.approx(np.sqrt(2 * BLOCKS - 1), rel=0.1)
    assert Follower(weighed, own, fits[0]).refitted(follower.run + shown * ~judged).run > 0.1


def test_no_run_is_asked_for_of_which_nothing_would_serve(proposed, monkeypatch):
    _, prepared, fits, _ = proposed
    own = len(prepared.weighed.model.target)
    elsewhere = lambda weighed: 2 * (weighed.chosen & (np.arange(len(weighed.chosen)) < own)[:, None],)  # noqa: E731
    monkeypatch.setattr(experiment, "served", elsewhere)
    assert not propose(prepared, [[h] for h in fits], noise=1.0).signal


def test_of_a_run_too_short_to_be_divided_all_is_fitted_and_judged(proposed):
    record, prepared, _, _ = proposed
    moving = prepare(MACHINE, replace(record, rest=False))  # of which the run stands for itself
    weighed = after(moving, asked(record, np.zeros((60, 1))))
    assert weighed.chosen.any() and all((part == weighed.chosen).all() for part in served(weighed))


def test_a_relaxing_spring_follows_a_creeping_drive_a_long_way():
    """Far along its own curve, where its tangent, taken where nothing relaxes yet, says that it stays behind."""
    prepared = prepare(MACHINE, measured(slowly(12.0), lambda q, v: 0.0, np.random.default_rng(6), 0.01))
    base, record = prepared.base.fit, prepared.weighed.model.record

    def sized(name: str, form: str, share: float) -> SimpleNamespace:
        """A hypothesis whose first size is a share of what is usual."""
        free = (*base.free, *effect_parameters((Candidate(name, form, (0,)),), prepared.weighed.model.scales))
        first = len(base.free)
        x = np.array([*base.x, *(f.center if k else share * f.sd for k, f in enumerate(free[first:]))])
        return SimpleNamespace(fit=SimpleNamespace(free=free, x=x))

    both = after(prepared, asked(record, 2000.0 * signals(MACHINE, record.step, 4000)["strong noise"]))
    names = sized("piezo_creep", "kelvin_voigt", 1.0), sized("viscoelasticity", "maxwell", 0.01)
    creep, relaxing = (Follower(both, len(record), h) for h in names)
    assert relaxing.foreseen(creep.run).run > 3.0
    assert relaxing.refitted(creep.run).run < 0.01


def test_what_diverges_shows_nothing(proposed):
    record, prepared, fits, _ = proposed
    drives = 1e200 * np.ones((4000, 1))
    both = after(prepared, asked(record, drives))
    hard, soft = (Follower(both, len(record), h) for h in fits)
    assert not np.isfinite(hard.run).all() and np.isfinite(soft.run).all()
    assert hard.foreseen(soft.run) == hard.refitted(soft.run) == soft.foreseen(hard.run) == Apart(0.0, 0.0)


def test_two_runs_from_rest_with_late_biased_sensors_are_explained_as_well_as_one():
    """Each begins anew: nothing is left over where one ends and the other begins, and the clocks' shift is found."""
    drives = 0.8 * oscillator(friction)[1].drives[:, 0]
    read, clean = ([measured(drives[:n], friction, np.random.default_rng(n), noise, late=4) for n in (9001, 6000)] for noise in (0.01, 0.0))
    records = [replace(record, readings=record.readings + 0.5) for record in read]  # a fifth of the motion
    analysis = analyse(MACHINE, joined(records))
    assert analysis.verdict.verdict == "named"
    assert [e.effect for e in analysis.verdict.set[0].effects] == ["coulomb_friction"]
    best, model = analysis.search.best, analysis.prepared.weighed.model
    own = np.concatenate([noisy.readings - without.readings for noisy, without in zip(read, clean, strict=True)])
    judged = analysis.prepared.judged
    assert best.left < 1.05 * np.mean((own[judged] / analysis.search.weighed.sigma) ** 2)  # what the noise itself leaves there
    half = 0.05e-3  # s: what is measured is the coordinate half a small step after the drive
    assert model.delay + best.fit.sensors.shift == pytest.approx(0.4e-3 - half, abs=0.02e-3)
