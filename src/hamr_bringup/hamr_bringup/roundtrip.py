"""Two processes that talk through ROS: `python -m hamr_bringup.roundtrip answer` and `... ask`, which prints middleware and seconds."""

from __future__ import annotations

import sys
import time

import rclpy
from std_msgs.msg import Empty

QUESTION, ANSWER = "/hamr_doctor/question", "/hamr_doctor/answer"
PATIENCE = 8.0  # s


def main(role: str) -> int:
    """Exit status 0 once the peer was heard; who answers goes on until its time is over or it is ended."""
    asks, heard = role == "ask", []
    rclpy.init()
    node = rclpy.create_node(f"hamr_doctor_{role}")
    out = node.create_publisher(Empty, QUESTION if asks else ANSWER, 1)
    node.create_subscription(Empty, ANSWER if asks else QUESTION, heard.append, 1)
    start = time.monotonic()
    while time.monotonic() - start < PATIENCE and not (asks and heard):
        if asks or heard:
            out.publish(Empty())
        rclpy.spin_once(node, timeout_sec=0.02)
    seconds = time.monotonic() - start
    node.destroy_node()
    sys.stdout.write(f"{rclpy.get_rmw_implementation_identifier()} {seconds:.2f}\n")
    rclpy.shutdown()
    return 0 if heard else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
