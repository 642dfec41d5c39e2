"""Model files: exact, remade to the byte, and refused with one clear sentence when they do not fit."""

from __future__ import annotations

import json

import numpy as np
import pytest
from residual_samples import random_network

from hamr_description.errors import ModelError
from hamr_sim_residual import model_file
from hamr_sim_residual.fit_series import limits, prior
from hamr_sim_residual.mlp import Mlp
from hamr_sim_residual.model_file import Model
from hamr_sim_residual.network import Network
from hamr_sim_residual.residual_plant import SHIPPED, residual_plant
from hamr_sim_residual.series import Series


def series_network() -> Network:
    law = Series(2)
    return Network(law, np.concatenate([limits(), prior(law).mean + np.random.default_rng(0).standard_normal(len(prior(law).mean)) / 3]))


@pytest.mark.parametrize("network", [series_network(), random_network(Mlp("robot", (7, 5)))], ids=["series", "mlp"])
def test_round_trip_is_exact(network, tmp_path):
    path = model_file.save(Model(network, {"seed": 3}), tmp_path / "new" / "a.json")
    loaded = model_file.load(path)
    assert loaded.network.law == network.law
    assert loaded.training == {"seed": 3}
    np.testing.assert_array_equal(loaded.network.values, network.values)
    assert model_file.save(loaded, tmp_path / "b.json").read_bytes() == path.read_bytes()
    assert [file.name for file in path.parent.iterdir()] == ["a.json"]


def _edit(key, change):
    def edit(content):
        content[key] = change(content[key])
        return content

    return edit


MISFITS = {
    "another format": (_edit("format", lambda x: x + "0"), "format"),
    "joints in another order": (_edit("joints", lambda x: x[::-1]), "joints"),
    "another unit": (_edit("units", lambda x: x | {"torque": "N m"}), "units"),
    "another rate": (_edit("servo_hz", lambda x: x // 2), "servo_hz"),
    "other physics": (_edit("physics", lambda x: "0" * len(x)), "physics"),
    "unknown law": (_edit("law", lambda x: {"kind": "oracle"}), "law"),
    "law without its size": (_edit("law", lambda x: {"kind": "series"}), "degree"),
    "law of another size": (_edit("law", lambda x: x | {"degree": 3}), "weights"),
    "weight missing": (_edit("weights", lambda x: x[1:]), "weights"),
    "weight not a number": (_edit("weights", lambda x: ["__import__('os')", *x[1:]]), "weights"),
    "weight not finite": (_edit("weights", lambda x: [float("inf"), *x[1:]]), "weights"),
    "an entry too many": (lambda content: content | {"code": "1"}, "code"),
    "a list": (lambda content: [content], "format"),
}


@pytest.mark.parametrize(("edit", "word"), MISFITS.values(), ids=MISFITS)
def test_what_does_not_fit_is_refused(edit, word, tmp_path):
    path = model_file.save(Model(series_network()), tmp_path / "model.json")
    path.write_text(json.dumps(edit(json.loads(path.read_text()))))
    with pytest.raises(ModelError, match=word) as error:
        model_file.load(path)
    assert str(path) in str(error.value)
    assert str(error.value).count("\n") == 0


def test_impossible_networks_are_refused(tmp_path):
    path = model_file.save(Model(random_network(Mlp("leg", (4,)))), tmp_path / "model.json")
    content = json.loads(path.read_text())
    for hidden in ([], [0], ["4"], [10**9], 4):
        path.write_text(json.dumps(content | {"law": {"kind": "mlp", "scope": "leg", "hidden": hidden}}))
        with pytest.raises(ModelError, match="law"):
            model_file.load(path)


@pytest.mark.parametrize("bytes_", [b"", b"\x80\x04cos\nsystem\n", b'{"format": ', b"\xff\xfe"], ids=["empty", "pickle", "cut", "binary"])
def test_files_that_are_no_models(bytes_, tmp_path):
    path = tmp_path / "model.json"
    path.write_bytes(bytes_)
    with pytest.raises(ModelError, match="no residual model"):
        model_file.load(path)


def test_missing_file_and_empty_path(tmp_path):
    with pytest.raises(ModelError, match="no residual model"):
        residual_plant(tmp_path / "none.json")
    assert residual_plant("").name == "simple"


def test_shipped_model_fits_and_says_where_it_comes_from():
    training = model_file.load(SHIPPED).training
    assert {"method", "architecture", "seed", "data", "seconds", "versions"} <= set(training)
    assert residual_plant(SHIPPED) is residual_plant(str(SHIPPED))
