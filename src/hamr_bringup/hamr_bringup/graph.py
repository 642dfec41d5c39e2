"""The graph of nodes as plain data: what `hamr up` starts as processes and `ros2 launch` as well."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import yaml

from hamr_description.errors import ConfigError

NODES = ("simulator", "leg_controller", "excitation", "policy", "recorder")
BACKENDS = ("full", "residual", "simple", "simple_published")


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What to run.

    Attributes:
        backend: full, residual, simple or simple_published.
        engine: kernel or mujoco.
        environment: ground or suspended.
        friction: coefficient of the ground; None for the default.
        residual: residual model file, for the residual backend.
        effects: effects file, what is added to the model; empty for nothing.
        policy: policy files, with commas; empty for no policy: targets may come from anyone.
        command: what the policy does until /cmd_vel says otherwise: forward, backward, left, right, or nothing.
        excitation: parameters of an excitation that drives in the controller's place, as of hamr_bags.excitation; empty for none.
        bag: folder of the bag; empty for none.
        seconds: sim time; 0 for no end.
        real_time_factor: sim time over wall time; 0 for as fast as possible.
        samples_per_frame: servo samples in each /servo message.
        seed: of the initial state.
        parameters: file with parameters of any of the nodes, as ROS 2 has them (config/hamr.yaml is one); what a run sets itself wins.
    """

    backend: str = "full"
    engine: str = "kernel"
    environment: str = "ground"
    friction: float | None = None
    residual: str = ""
    effects: str = ""
    policy: str = ""
    command: str = ""
    excitation: dict[str, object] = field(default_factory=dict)
    bag: str = ""
    seconds: float = 0.0
    real_time_factor: float = 1.0
    samples_per_frame: int = 16
    seed: int = 0
    parameters: str = ""

    def __post_init__(self) -> None:
        if self.backend not in BACKENDS:
            raise ConfigError(f"There is no backend '{self.backend}'; choose one of {', '.join(BACKENDS)}.")
        if (self.backend == "residual") != bool(self.residual):
            raise ConfigError(f"Backend '{self.backend}' and residual model file '{self.residual}' do not fit; give both or neither.")
        if self.policy and self.excitation:
            raise ConfigError("A run has either a policy or an excitation; leave one of them out.")


def run_of_words(words: Mapping[str, str]) -> Run:
    """A run from text, as a launch file has it: numbers and groups as YAML; empty for the default.

    Raises:
        ConfigError: a word that does not fit.
    """
    values = {}
    for entry in fields(Run):
        word = words.get(entry.name, "")
        if not word:
            continue
        kind = _KINDS.get(entry.type.split("[")[0].split(" ")[0], str)
        try:
            values[entry.name] = word if kind is str else kind(yaml.safe_load(word))
        except (ValueError, TypeError, yaml.YAMLError):
            raise ConfigError(f"{entry.name} is '{word}'; give it as {entry.type}.") from None
    return Run(**values)


_KINDS = {"float": float, "int": int, "dict": dict}


@dataclass(frozen=True, slots=True)
class NodeSpec:
    """One node of the graph.

    Attributes:
        package, executable: as for `ros2 run`.
        name: of the node.
        parameters: those that differ from the node's defaults.
        ends_run: whether the run is over when this node ends.
        file: with more parameters; empty for none.
    """

    package: str
    executable: str
    name: str
    parameters: dict[str, object]
    ends_run: bool = False
    file: str = ""

    def arguments(self) -> list[str]:
        """The parameters as command line arguments."""
        given = (word for key, value in self.parameters.items() for word in ("-p", f"{key}:={json.dumps(value)}"))
        return ["--ros-args", *(["--params-file", self.file] if self.file else []), *given]


def graph(run: Run) -> list[NodeSpec]:
    """The nodes of a run, the recorder last.

    Waiting makes a run the same every time: the simulator starts its clock when the driver is on the bus, the controller joins the bus
    when the policy answers, and everyone begins when the recorder listens.
    """
    recorded = ["recorder"] if run.bag else []
    bus = {"samples_per_frame": run.samples_per_frame}
    nodes = [_simulator(run, {**bus, "wait_for": ",".join(["driver", *recorded])})]
    if run.excitation:
        parameters = {**bus, "excitation": json.dumps(run.excitation), "wait_for": ",".join(recorded)}
        nodes.append(NodeSpec("hamr_bags", "excitation", "excitation", parameters))
    else:
        awaited = [*(["targets"] if run.policy else []), *recorded]
        nodes.append(NodeSpec("hamr_controller", "leg_controller", "leg_controller", {**bus, "wait_for": ",".join(awaited)}))
    if run.policy:
        parameters = {"policy": run.policy, "command": run.command, "wait_for": ",".join(recorded)}
        nodes.append(NodeSpec("hamr_policy", "policy", "policy", parameters))
    if run.bag:
        nodes.append(NodeSpec("hamr_bags", "recorder", "recorder", {"bag": run.bag}))
    return _with_file(nodes, run.parameters) if run.parameters else nodes


def _with_file(nodes: list[NodeSpec], file: str) -> list[NodeSpec]:
    """The nodes, those that a parameter file speaks to with that file."""
    try:
        keys = yaml.safe_load(Path(file).read_text())
    except (OSError, yaml.YAMLError) as error:
        raise ConfigError(f"The parameter file '{file}' cannot be read ({error}); give a YAML file.") from None
    if not isinstance(keys, dict) or not keys:
        raise ConfigError(f"The parameter file '{file}' names no node; see config/hamr.yaml of hamr_bringup.")
    if unknown := [key for key in keys if key.lstrip("/") not in (*NODES, "**")]:
        raise ConfigError(f"The parameter file '{file}' names '{unknown[0]}', which is no node of this graph ({', '.join(NODES)}).")
    return [replace(node, file=file) if {node.name, f"/{node.name}", "/**"} & set(keys) else node for node in nodes]


def _simulator(run: Run, parameters: dict[str, object]) -> NodeSpec:
    parameters |= {
        "engine": run.engine,
        "environment": run.environment,
        "seed": run.seed,
        "real_time_factor": float(run.real_time_factor),
        "duration": float(run.seconds),
        "excitation": json.dumps(run.excitation) if run.excitation else "",
        "effects": run.effects,
    }
    if run.friction is not None:
        parameters["friction"] = float(run.friction)
    if run.backend == "full":
        return NodeSpec("hamr_sim_full", "sim", "simulator", parameters, ends_run=True)
    parameters |= {"backend": run.backend, "residual": run.residual}
    return NodeSpec("hamr_sim_residual", "sim", "simulator", parameters, ends_run=True)
