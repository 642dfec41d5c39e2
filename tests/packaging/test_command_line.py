"""The contract of `hamr COMMAND [--json]`: what goes to standard output, what the exit status says, one sentence for each mistake."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import asdict, fields

import pytest

from hamr_bringup.cli import COMMANDS
from hamr_bringup.commands.train import Command as Train
from hamr_bringup.commands.up import Command as Up
from hamr_bringup.graph import Run
from hamr_bringup.present import as_json_text, as_text

HAMR = [sys.executable, "-m", "hamr_bringup.cli"]


def hamr(*words: str, **environment: str) -> subprocess.CompletedProcess:
    return subprocess.run([*HAMR, *words], capture_output=True, text=True, env={**os.environ, **environment}, check=False)


def test_help_names_every_command_and_imports_nothing_heavy():
    code = "import sys; from hamr_bringup.cli import run; run(['--help']); print(sorted(sys.modules), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert all(f"  {command} " in done.stdout for command in COMMANDS)
    assert not {"torch", "numba", "mujoco", "rclpy", "scipy", "matplotlib"} & set(eval(done.stderr))


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_has_examples_that_name_it(command):
    done = hamr(command, "--help")
    assert done.returncode == 0
    examples = [line for line in done.stdout.split("Examples:")[1].splitlines() if line.startswith("  hamr ")]
    assert examples
    assert all(line.split()[1] == command for line in examples)


def test_without_a_command_help_goes_to_standard_error():
    done = hamr()
    assert done.returncode == 2
    assert done.stdout == ""
    assert "usage: hamr" in done.stderr


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        (("dokter",), 2, "did you mean 'doctor'?"),
        (("xyz",), 2, "hamr --help"),
        (("run", "hamr_sim_full", "simulator"), 1, "hamr_sim_full simulator"),
        (("render", "no/such/bag", "--out", "x.mp4"), 1, "no/such/bag"),
        (("render", "no/such/bag", "--out", "x.avi"), 1, ".mp4"),
        (("render", "no/such/bag", "--out", "x.mp4", "--camera", "moon"), 1, "moon"),
    ],
)
def test_a_mistake_is_one_sentence_on_standard_error(words, status, says):
    done = hamr(*words)
    assert done.returncode == status
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("hamr: ")
    assert says in lines[0]


def test_with_json_a_mistake_is_an_object_too():
    done = hamr("render", "no/such/bag", "--out", "x.mp4", "--json")
    assert done.returncode == 1
    found = json.loads(done.stdout)
    assert found["ok"] is False
    assert found["error"] in done.stderr


def test_a_missing_argument_is_a_usage_error_without_traceback():
    done = hamr("render")
    assert done.returncode == 2
    assert done.stdout == ""
    assert "--out" in done.stderr
    assert "Traceback" not in done.stderr


def test_json_is_alone_on_standard_output_even_when_children_write_there():
    """The result is one JSON line, whatever the command, a C library or a child writes to standard output meanwhile."""
    code = """
import os, subprocess, sys, types
from hamr_bringup import cli
class Command:
    @classmethod
    def from_words(cls, words): return cls()
    def run(self):
        print("from python"); os.write(1, b"from c\\n"); subprocess.run(["echo", "from a child"])
        return {"ok": False, "nan": float("nan")}
cli._module = lambda name: types.SimpleNamespace(Command=Command, __doc__="A command.")
sys.exit(cli.run([cli.COMMANDS[0], "--json"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert json.loads(done.stdout) == {"ok": False, "nan": None}
    assert {"from python", "from c", "from a child"} <= set(done.stderr.split("\n"))
    assert done.returncode == 1, "a result that is not ok is no success"


def test_interrupt_ends_with_status_130_and_one_sentence():
    code = """
import signal, sys, time, types
from hamr_bringup import cli
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the tests themselves run in the background
class Command:
    @classmethod
    def from_words(cls, words): return cls()
    def run(self):
        sys.stderr.write("ready\\n"); sys.stderr.flush()
        time.sleep(60)
cli._module = lambda name: types.SimpleNamespace(Command=Command, __doc__="A command.")
sys.exit(cli.run([cli.COMMANDS[0]]))
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr.readline() == "ready\n"
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 130
    assert time.monotonic() - start < 20
    assert said.strip().splitlines() == [f"hamr: {COMMANDS[0]}: interrupted."]


def test_up_offers_what_a_run_has_with_the_same_defaults():
    offered = asdict(Up())
    assert Run(**offered) == Run()
    assert {field.name for field in fields(Run)} - set(offered) == {"excitation"}


def test_result_for_people_is_a_table_and_lines():
    text = as_text({"ok": True, "rows": [{"name": "mass", "value": 1.41, "ok": True}, {"name": "sag", "value": None, "ok": False}]})
    assert [line.split() for line in text.splitlines()] == [
        ["name", "value", "ok"], ["mass", "1.41", "yes"], ["sag", "-", "no"], ["ok:", "yes"],
    ]  # fmt: skip


def test_a_trainings_curve_is_for_programs_only():
    result = {"policy": "p.onnx", "curve": [[2048, 1.0]] * 500}
    assert Train["policy"].text(None, result) == "policy: p.onnx\n"


def test_json_takes_numpy_and_paths(tmp_path):
    import numpy as np

    result = {"array": np.array([1.0, np.inf]), "scalar": np.float32(0.5), "flag": np.bool_(True), "path": tmp_path}
    assert json.loads(as_json_text(result)) == {"array": [1.0, None], "scalar": 0.5, "flag": True, "path": str(tmp_path)}


def test_doctor_finds_this_environment_healthy():
    done = hamr("doctor", "--json")
    found = json.loads(done.stdout)
    rows = {row["name"]: row for row in found["rows"]}
    assert all(set(row) == {"name", "ok", "value", "advice"} for row in found["rows"])
    assert rows["ROS between processes"]["ok"], rows["ROS between processes"]
    assert rows["numpy"]["value"] == __import__("numpy").__version__
    assert (done.returncode == 0) == found["ok"] == all(row["ok"] for row in found["rows"])
    assert all(row["advice"] for row in found["rows"] if not row["ok"])


def test_doctor_says_when_ros_is_cut_off():
    rows = {row["name"]: row for row in json.loads(hamr("doctor", "--json", RMW_IMPLEMENTATION="rmw_of_nobody").stdout)["rows"]}
    assert not rows["ROS between processes"]["ok"]
    assert rows["ROS between processes"]["advice"]


def test_inherited_mark_of_another_environment_is_healed():
    """With the mark of the ROS wheels set but without their libraries, rclpy could not be imported."""
    done = hamr("doctor", "--json", _ROS_WHEELS_BOOTSTRAP_COMPLETE="1", LD_LIBRARY_PATH="", AMENT_PREFIX_PATH="")
    rows = {row["name"]: row for row in json.loads(done.stdout)["rows"]}
    assert rows["ROS between processes"]["ok"], rows["ROS between processes"]
