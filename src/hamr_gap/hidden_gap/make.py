"""`python -m hidden_gap.make --group single --seed 3 --out DIR --answer FILE`: one bag, and its answer elsewhere."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from hamr_description.errors import HamrError

from .bag import write
from .draw import GROUPS, draw


def main(arguments: list[str] | None = None) -> str | None:
    """What went wrong in one sentence, for `sys.exit`; None if all went well."""
    parser = argparse.ArgumentParser(prog="python -m hidden_gap.make", description="Make a bag of a leg that hides an effect.")
    parser.add_argument("--group", choices=GROUPS, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True, help="bag folder to make; nothing in it tells the answer")
    parser.add_argument("--answer", type=Path, required=True, help="JSON file with what is hidden")
    parser.add_argument("--strength", type=float, default=5.0, help="of each effect, in floors of the sensor noise (default 5)")
    parser.add_argument("--seconds", type=float, default=12.0)
    given = parser.parse_args(arguments)
    try:
        answer = write(draw(given.group, given.seed, strength=given.strength, seconds=given.seconds), given.out)
        given.answer.write_text(json.dumps(answer, indent=2) + "\n")
    except (HamrError, OSError) as error:
        return str(error)
    return None


if __name__ == "__main__":
    sys.exit(main())
