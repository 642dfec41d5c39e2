"""The servo bus between real processes: every sample answered, whoever is killed, stopped or started again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hamr_controller import bus, bus_file
from hamr_controller.bus_ends import DriverEnd, Progress, Reply, SimulatorEnd
from hamr_controller.bus_file import BusFile, BusTaken, Role, bus_path
from hamr_controller.plan import Plan
from hamr_description.errors import ConfigError

PEER = Path(__file__).with_name("bus_peer.py")
SAMPLE = np.zeros((7, 8))


@pytest.fixture(autouse=True)
def own_directory(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def peer():
    """Starts peers; none outlives the test."""
    started = []

    def start(role: str, run: str = "main", volts: float = 30.0) -> subprocess.Popen:
        command = [sys.executable, str(PEER), role, run, str(volts)]
        started.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


def lines_until(process: subprocess.Popen, start: str) -> list[str]:
    """What the peer says up to and with the first line that starts so; the test's time limit is the reader's."""
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip())
        if line.startswith(start):
            return lines
    raise AssertionError(f"{lines[-3:]} {process.stderr.read()}")


def period(end: SimulatorEnd, number: int) -> tuple[Reply, np.ndarray]:
    """One whole period: the reply to its first sample, and all voltages (80, 8)."""
    volts = np.full((80, 8), np.nan)
    end.offer(number, SAMPLE)
    while (reply := end.poll(volts[0])) is Reply.WAITING:
        pass
    for k in range(1, 80):
        end.answer(k, SAMPLE, volts[k])
    return reply, volts


def until(end: SimulatorEnd, first: int, wanted: Reply) -> int:
    """Periods until the wanted reply; the number of the next."""
    for number in range(first, first + 2_000_000):
        if period(end, number)[0] is wanted:
            return number + 1
    raise AssertionError("never")


def test_every_sample_of_every_period_is_answered_by_the_law(peer):
    """The driver lives in another process; its answers to moving samples are those that its own record shows, none twice, none lost."""
    end = SimulatorEnd("main")
    peer("driver", volts=100.0)
    number = until(end, 0, Reply.READY)
    for _ in range(200):
        reply, volts = period(end, number)
        assert reply is Reply.READY and (volts == 100.0).all()
        number += 1
    end.close()


def test_the_exchange_carries_angles_and_rates_exactly():
    """Both ends in one process, one thread: the driver's compiled loop sees each sample, bit for bit."""
    simulator, driver = SimulatorEnd("main"), DriverEnd("main")
    assert driver.connect()
    driver.join()
    rng = np.random.default_rng(0)
    kp, kd, target = rng.normal(0, 100, 8), rng.normal(0, 1, 8), rng.normal(0, 0.1, 8)
    plan = Plan(np.full((80, 8), 112.5), target, kp, kd)
    sample, volts, recorded = rng.normal(0, 0.1, (7, 8)), np.empty(8), np.empty((80, 8))
    simulator.offer(0, sample)
    assert driver.next_period() == 0
    assert driver.drive(0, plan, recorded) is Progress.PENDING  # only the first sample is there yet
    assert simulator.poll(volts) is Reply.READY
    expected = np.clip(112.5 + kp * (target - sample[0]) - kd * sample[1], 0, 225)
    np.testing.assert_allclose(volts, expected, rtol=0, atol=1e-11)
    assert (volts == recorded[0]).all()
    simulator.close()


def test_without_a_driver_the_voltage_is_neutral_at_once():
    end = SimulatorEnd("main")
    reply, volts = period(end, 0)
    assert reply is Reply.ABSENT and (volts == 112.5).all() and not end.present
    end.close()


def test_a_killed_driver_leaves_the_neutral_voltage_and_a_new_one_takes_over(peer):
    end = SimulatorEnd("main")
    first = peer("driver", volts=10.0)
    number = until(end, 0, Reply.READY)
    first.send_signal(signal.SIGKILL)
    first.wait()
    reply, volts = period(end, number)
    assert (volts[-1] == 112.5).all() and not end.present
    peer("driver", volts=20.0)
    number = until(end, number + 1, Reply.READY)
    reply, volts = period(end, number)
    assert reply is Reply.READY and (volts == 20.0).all()
    end.close()


def test_a_driver_killed_within_a_period_leaves_the_rest_of_it_neutral(peer):
    end = SimulatorEnd("main")
    driver = peer("driver", volts=10.0)
    number = until(end, 0, Reply.READY)
    volts = np.empty((80, 8))
    end.offer(number, SAMPLE)
    while end.poll(volts[0]) is not Reply.READY:
        pass
    for k in range(1, 80):
        if k == 40:
            driver.kill()
            driver.wait()
        end.answer(k, SAMPLE, volts[k])
    assert (volts[:40] == 10.0).all() and (volts[40:] == 112.5).all() and not end.present
    end.close()


def test_a_silent_driver_is_given_up_after_the_patience_and_welcome_when_it_speaks_again(peer):
    end = SimulatorEnd("main", patience_s=0.05)
    driver = peer("driver", volts=10.0)
    number = until(end, 0, Reply.READY)
    os.kill(driver.pid, signal.SIGSTOP)
    os.waitpid(driver.pid, os.WUNTRACED)
    end.offer(number, SAMPLE)
    volts = np.zeros(8)
    assert end.poll(volts) in (Reply.WAITING, Reply.READY)  # alive, so it is waited for
    end.answer(1, SAMPLE, volts)
    assert (volts == 112.5).all() and not end.present
    assert period(end, number + 1)[0] is Reply.ABSENT  # and does not cost the patience again
    os.kill(driver.pid, signal.SIGCONT)
    number = until(end, number + 2, Reply.READY)
    assert (period(end, number)[1] == 10.0).all()
    end.close()


def test_a_late_answer_is_never_taken_for_another_sample():
    end = SimulatorEnd("main")
    file = BusFile(bus_path("main"))
    assert file.lock(Role.DRIVER)
    file.words[bus.JOINS_WORD] += 1
    end.offer(7, SAMPLE)
    file.reals[bus.VOLT_REALS : bus.VOLT_REALS + 8] = 200.0
    file.words[bus.ANSWER_WORD] = bus.first_number(7) - 1
    volts = np.zeros(8)
    assert end.poll(volts) is Reply.WAITING
    file.words[bus.ANSWER_WORD] = bus.first_number(7)
    assert end.poll(volts) is Reply.READY and (volts == 200.0).all()
    file.close()
    end.close()


def test_a_killed_simulator_leaves_a_file_that_the_next_one_sweeps_and_the_driver_joins_again(peer):
    simulator, driver = peer("simulator"), peer("driver", volts=10.0)
    lines_until(driver, "DONE")
    path = bus_path("main")
    first = BusFile(path)
    simulator.kill()
    simulator.wait()
    assert path.exists() and not first.held(Role.SIMULATOR)
    end = SimulatorEnd("main")
    assert not first.is_at_path() and BusFile(path).words[bus_file.GENERATION_WORD] != first.words[bus_file.GENERATION_WORD]
    until(end, 0, Reply.READY)
    lines_until(driver, "joined")
    lines_until(driver, "DONE")
    end.close()
    assert not path.exists()


def test_stale_files_of_other_runs_are_swept_and_living_ones_left_alone(peer):
    dead, living = peer("simulator", "dead"), peer("simulator", "living")
    for process in (dead, living):
        lines_until(process, "made")
    dead.kill()
    dead.wait()
    SimulatorEnd("third").close()
    assert not bus_path("dead").exists() and bus_path("living").exists()


def test_two_runs_side_by_side_do_not_meet(peer):
    ends = {name: SimulatorEnd(name) for name in ("a", "b")}
    for name, volts in (("a", 10.0), ("b", 20.0)):
        peer("driver", name, volts)
    for name, volts in (("a", 10.0), ("b", 20.0)):
        number = until(ends[name], 0, Reply.READY)
        assert (period(ends[name], number)[1] == volts).all()
        ends[name].close()


def test_domains_are_apart(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    first = bus_path("main")
    monkeypatch.setenv("ROS_DOMAIN_ID", "8")
    assert bus_path("main") != first


def test_each_end_has_one_owner():
    end = SimulatorEnd("main")
    with pytest.raises(BusTaken, match=f"process {os.getpid()}"):
        SimulatorEnd("main")
    drivers = [DriverEnd("main"), DriverEnd("main")]
    assert all(driver.connect() for driver in drivers)
    drivers[0].join()
    with pytest.raises(BusTaken, match=f"process {os.getpid()}"):
        drivers[1].join()
    drivers[0].leave()
    drivers[1].join()
    end.close()
    assert drivers[1].next_period() is None and not drivers[1].joined
    SimulatorEnd("main").close()  # a closed end gives its place free


def test_a_driver_that_has_not_joined_yet_follows_from_one_simulator_to_the_next():
    driver, first = DriverEnd("main"), SimulatorEnd("main")
    assert driver.connect() and driver.newest_period == -1
    first.offer(7, SAMPLE)
    assert driver.newest_period == 7
    first.close()
    second = SimulatorEnd("main")
    assert not driver.connect() and not driver.connected  # it must notice, not change over in silence
    assert driver.connect() and driver.newest_period == -1
    second.close()


@pytest.mark.parametrize("content", [b"", b"x" * 512, bytes(512), bytes(4096)])
def test_a_foreign_file_is_refused_with_a_sentence(content):
    path = bus_path("main")
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=rf"{path} is not a servo bus .*delete it\.$"):
        DriverEnd("main").connect()
    with pytest.raises(ConfigError, match="is not a servo bus"):
        SimulatorEnd("main")
    assert path.read_bytes() == content


@pytest.mark.parametrize("name", ["", "a/b", "..", "a b"])
def test_a_run_name_is_no_path(name):
    with pytest.raises(ConfigError, match="run name"):
        bus_path(name)
