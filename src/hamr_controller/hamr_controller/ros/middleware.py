"""Settings of the DDS implementation of these nodes."""

from __future__ import annotations

import os

from ..bus_file import run_directory

_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"  # name in Fast DDS 2, which ROS 2 Jazzy has
#: A message or an acknowledgement that got lost is asked for again at the next heartbeat. Every 3 s, the default, would let a run in
#: lock-step, or the recorder's publishers, stand still that long.
_PROFILES = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
  <data_writer profile_name="hamr" is_default_profile="true">
    <times><heartbeatPeriod><sec>0</sec><nanosec>20000000</nanosec></heartbeatPeriod></times>
  </data_writer>
</profiles></dds>
"""


def configure() -> None:
    """Before rclpy starts: the profiles of this project, unless the user has some."""
    if _VARIABLE in os.environ:
        return
    path = run_directory() / "fastdds.xml"
    if not path.exists() or path.read_text() != _PROFILES:
        part = path.with_name(f"fastdds-{os.getpid()}.part")
        part.write_text(_PROFILES)
        part.rename(path)  # another node may be reading it
    os.environ[_VARIABLE] = str(path)
