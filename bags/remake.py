"""Make the bags of recipes.yaml, check them, and compare their numbers with digests.json.

Examples:
  python bags/remake.py                 all, into out/bags
  python bags/remake.py noise trot      some
  python bags/remake.py --accept        write the new digests
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path

import yaml

from hamr_bags.check import check
from hamr_bags.excitation import excitation
from hamr_bags.reader import load
from hamr_bags.recording import digest
from hamr_bringup.direct import direct
from hamr_bringup.graph import Run

HERE = Path(__file__).parent
DIGESTS = HERE / "digests.json"


def recipes() -> tuple[dict, dict[str, dict]]:
    """What all bags share, and the excitation of each, by name."""
    tree = yaml.safe_load((HERE / "recipes.yaml").read_text())
    return tree["common"], tree["training"] | tree["held_out"]


def make(name: str, out: Path) -> str:
    """Make one bag anew; returns the digest of its measured channels."""
    common, signals = recipes()
    parameters = excitation(**signals[name]).parameters
    shutil.rmtree(out, ignore_errors=True)
    direct(Run(**common, excitation=parameters, seconds=parameters["seconds"], bag=str(out)))
    report = check(out)
    if not report.ok:
        raise SystemExit(f"{out} is not whole: {[row.name for row in report.rows if not row.ok]}")
    for warning in report.warnings:
        sys.stderr.write(f"  {warning}\n")
    return digest(load(out))


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="bags to make; default all")
    parser.add_argument("--out", type=Path, default=HERE.parent / "out" / "bags", help="folder for the bags")
    parser.add_argument("--accept", action="store_true", help="write the new digests")
    arguments = parser.parse_args()
    known = json.loads(DIGESTS.read_text()) if DIGESTS.exists() else {}
    if unknown := sorted(set(arguments.names) - set(recipes()[1])):
        parser.error(f"there is no recipe {unknown[0]}; there are {', '.join(recipes()[1])}")
    for name in arguments.names or recipes()[1]:
        found = make(name, arguments.out / name)
        sys.stdout.write(f"{name:22} {found[:16]} {'as before' if found == known.get(name) else 'differs'}\n")
        known[name] = found
    if arguments.accept:
        DIGESTS.write_text(json.dumps(known, indent=2) + "\n")


if __name__ == "__main__":
    main()
