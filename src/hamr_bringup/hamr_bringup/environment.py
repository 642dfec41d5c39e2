"""The environment that this process and its children need. Standard library only: it runs before anything else is imported."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


def prepare() -> None:
    """Set what is not set: one thread a process, local discovery, ROS logs in a temporary folder, rclpy's parts from pip.

    What the user has set stays. ROS from pip re-executes each Python once, with its libraries on LD_LIBRARY_PATH; a Python started by
    that of another environment inherits the mark that this is done, but not these libraries, so it starts once more without the mark.
    """
    libraries = next(Path(sys.prefix).glob("lib/python*/site-packages/ros_rclpy.libs"), None)
    if libraries and BOOTSTRAPPED in os.environ and str(libraries.resolve()) not in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep):
        del os.environ[BOOTSTRAPPED]
        os.execv(sys.executable, sys.orig_argv)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_LOG_DIR", str(Path(tempfile.gettempdir()) / f"hamr-log-{os.getuid()}"))
    if Path(sys.prefix, "share/ament_index/resource_index/packages/rclpy").exists():
        prefixes = [prefix for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
        if sys.prefix not in prefixes:
            os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([*prefixes, sys.prefix])
