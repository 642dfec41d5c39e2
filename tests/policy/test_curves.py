"""The picture of learning curves tells backends apart and seeds together."""

from __future__ import annotations

import json

from matplotlib import image

from hamr_policy.curves import _by_training, draw_curves


def test_trainings_are_told_apart_by_what_they_were_trained_on(tmp_path):
    trainings = (("walk", "full", ""), ("walk", "full", ""), ("walk", "simple", "noise"), ("turn", "full", ""))
    for i, (task, backend, disturbance) in enumerate(trainings):
        folder = tmp_path / str(i)
        folder.mkdir()
        settings = {"task": task, "backend": backend, "disturbance": disturbance}
        (folder / "training.json").write_text(json.dumps({"settings": settings, "curve": [[0, i], [10, 2 * i]]}))
    folders = sorted(tmp_path.iterdir())
    assert {label: len(curves) for label, curves in _by_training(folders, "walk").items()} == {"full": 2, "simple+noise": 1}
    assert _by_training(folders, "turn")["full"][0].tolist() == [[0, 3], [10, 6]]
    assert image.imread(draw_curves(folders, tmp_path / "curves.png")).std() > 0.05  # something is drawn
