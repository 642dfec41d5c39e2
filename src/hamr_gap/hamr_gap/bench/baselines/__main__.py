"""`python -m hamr_gap.bench.baselines`: see `run`."""

import sys

import tyro

from hamr_description.errors import HamrError

from .run import baselines

try:
    tyro.cli(baselines)
except HamrError as error:
    sys.exit(str(error))
