"""`python -m hamr_gap.bench`: see `run`."""

import tyro

from .run import bench

tyro.cli(bench)
