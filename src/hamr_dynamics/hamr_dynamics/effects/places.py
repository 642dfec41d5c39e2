"""Joints by name, or by what several of them have in common."""

from __future__ import annotations

from collections.abc import Sequence

from hamr_description.errors import ConfigError
from hamr_description.names import AXES, JOINTS, LEGS, MIRROR

_LEG_WORDS = {
    "front": [leg for leg in LEGS if MIRROR[leg][0] > 0], "rear": [leg for leg in LEGS if MIRROR[leg][0] < 0],
    "left": [leg for leg in LEGS if MIRROR[leg][1] > 0], "right": [leg for leg in LEGS if MIRROR[leg][1] < 0],
    "all": list(LEGS), **{leg: [leg] for leg in LEGS},
}  # fmt: skip
#: Word -> joints: each joint, a leg (fl), swing, lift, left, right, front, rear, all.
WORDS = {joint: (joint,) for joint in JOINTS}
WORDS |= {axis: tuple(joint for joint in JOINTS if joint.endswith(axis)) for axis in AXES}
WORDS |= {word: tuple(f"{leg}_{axis}" for leg in legs for axis in AXES) for word, legs in _LEG_WORDS.items()}


def joints_of(words: Sequence[str]) -> tuple[str, ...]:
    """Joints in canonical order.

    Raises:
        ConfigError: an unknown word, or a joint that is named twice.
    """
    found: list[str] = []
    for word in words:
        if word not in WORDS:
            raise ConfigError(f"there is no joint '{word}'; name joints ({', '.join(JOINTS)}), legs, {', '.join(AXES)} or "
                              "left, right, front, rear, all.")  # fmt: skip
        found += WORDS[word]
    if len(found) != len(set(found)):
        twice = next(joint for joint in found if found.count(joint) > 1)
        raise ConfigError(f"joint {twice} is named twice; leave one of them out.")
    return tuple(joint for joint in JOINTS if joint in found)


def legs_of(joints: Sequence[str]) -> tuple[str, ...]:
    """Legs whose joints these are; ConfigError if a leg has one of its joints only."""
    legs = tuple(leg for leg in LEGS if any(joint.startswith(leg) for joint in joints))
    if len(joints) != len(AXES) * len(legs):
        raise ConfigError(f"it acts on whole legs; name legs ({', '.join(LEGS)}), not single joints.")
    return legs
