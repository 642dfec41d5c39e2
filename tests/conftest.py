"""Every test process has its own ROS domain and log folder, one thread, and finds the parts of rclpy from pip."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile

from hypothesis import settings

from hamr_bringup.environment import prepare

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 101)  # the domains whose ports stay clear of the system's; 0 is the user's
os.environ["ROS_LOG_DIR"] = tempfile.mkdtemp(prefix="hamr-test-log-")
atexit.register(shutil.rmtree, os.environ["ROS_LOG_DIR"], ignore_errors=True)
prepare()

# Compilation falls into the first example, so no deadline; the same examples on every run.
settings.register_profile("hamr", deadline=None, derandomize=True)
settings.load_profile("hamr")
