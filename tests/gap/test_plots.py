"""Pictures of a report hold what they are given."""

from __future__ import annotations

import warnings
from io import BytesIO

from hamr_gap.showing.plots import left_by_names

NAMES = ("configuration_dependent_transmission", "configuration_dependent_inertia", "configuration_dependent_damping")


def test_names_of_three_effects_leave_room_for_the_bars():
    rows = [{"effects": " + ".join(f"{name} (fl_swing, fl_lift)" for name in NAMES[: k % 3 + 1]), "left": 0.1 / (k + 1)} for k in range(10)]
    figure = left_by_names(rows, [rows[0]["effects"]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a layout that collapses is only warned of
        figure.savefig(BytesIO(), format="svg")
    width, _ = figure.get_size_inches()
    assert figure.axes[0].get_position().width * width > 3.0
