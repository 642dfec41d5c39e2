"""Trained network to ONNX: one small graph from observations in their units to target hip angles in rad, and where it comes from."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import nn

from hamr_bags.run_info import parameters_hash
from hamr_description.names import JOINTS

from .observation import components
from .policy_file import INPUT, KEY, OUTPUT, interface
from .task import TARGET_LIMIT

OPSET, IR = 21, 10
LIBRARIES = ("numpy", "numba", "torch", "stable-baselines3", "gymnasium", "onnx")
ACTIVATIONS = {nn.Tanh: "Tanh", nn.ELU: "Elu"}


@dataclass(frozen=True, slots=True)
class Origin:
    """What a policy was trained for and on; see `train.Settings`."""

    task: str
    view: str
    backend: str
    residual: str
    disturbance: str
    seed: int
    steps: int
    effects: str = ""


def export(policy: ActorCriticPolicy, origin: Origin, path: str | Path) -> Path:
    """Writes the deterministic policy (the mean action); equal networks give equal bytes."""
    rows = components(origin.view)
    about = {
        **interface(origin.task, origin.view),
        "normalisation": {part: [row[part] for row in rows] for part in ("centre", "scale")},  # part of the graph
        **asdict(origin),
        "parameters_hash": parameters_hash(),
        "versions": {name: version(name) for name in LIBRARIES},
    }
    model = helper.make_model(graph(policy), opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR, producer_name="hamr")
    helper.set_model_props(model, {KEY: json.dumps(about)})
    onnx.checker.check_model(model)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(model.SerializeToString(deterministic=True))
    return path


def graph(policy: ActorCriticPolicy) -> onnx.GraphProto:
    """(observation - centre) / scale -> layers -> clip to [-1, 1] -> times the target limit."""
    nodes, constants = [], []

    def constant(name: str, values) -> str:
        constants.append(numpy_helper.from_array(np.asarray(values, np.float32), name))
        return name

    def node(kind: str, *inputs: str, **attributes) -> str:
        out = f"{kind.lower()}{len(nodes)}"
        nodes.append(helper.make_node(kind, inputs, [out], **attributes))
        return out

    normalise = policy.pi_features_extractor
    x = node("Sub", INPUT, constant("centre", normalise.centre))
    x = node("Div", x, constant("scale", normalise.scale))
    for layer in [*policy.mlp_extractor.policy_net, policy.action_net]:
        if isinstance(layer, nn.Linear):
            n = len(constants)
            weight = constant(f"weight{n}", layer.weight.detach())
            x = node("Gemm", x, weight, constant(f"bias{n}", layer.bias.detach()), transB=1)
        else:
            x = node(ACTIVATIONS[type(layer)], x)
    x = node("Clip", x, constant("low", -1.0), constant("high", 1.0))
    nodes.append(helper.make_node("Mul", [x, constant("limit", TARGET_LIMIT)], [OUTPUT]))
    seen = helper.make_tensor_value_info(INPUT, TensorProto.FLOAT, ["robots", len(normalise.centre)])
    wanted = helper.make_tensor_value_info(OUTPUT, TensorProto.FLOAT, ["robots", len(JOINTS)])
    return helper.make_graph(nodes, "policy", [seen], [wanted], constants)
