"""What a bag of this robot holds: the message type of every topic, and which topics are latched."""

from __future__ import annotations

from hamr_description.names import Topic

CLOCK = "rosgraph_msgs/msg/Clock"
JOINT_STATE = "sensor_msgs/msg/JointState"
ODOMETRY = "nav_msgs/msg/Odometry"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
STRING = "std_msgs/msg/String"

#: Message type of each topic (design: topics).
TYPES = {
    Topic.CLOCK: CLOCK,
    Topic.JOINT_STATES: JOINT_STATE,
    Topic.ODOM: ODOMETRY,
    Topic.LEG_TARGETS: JOINT_STATE,
    Topic.CMD_VEL: "geometry_msgs/msg/Twist",
    Topic.SERVO_JOINTS: TRAJECTORY,
    Topic.SERVO_ACTUATORS: TRAJECTORY,
    Topic.SERVO_VOLTAGES: TRAJECTORY,
    Topic.DIAGNOSTICS: "diagnostic_msgs/msg/DiagnosticArray",
    Topic.RUN_INFO: STRING,
    Topic.ROBOT_DESCRIPTION: STRING,
}

#: Published once; late subscribers get them too (transient local), also from `ros2 bag play`.
LATCHED = frozenset({Topic.RUN_INFO, Topic.ROBOT_DESCRIPTION})

#: The topics whose messages hold the servo samples of one 4 ms period.
SERVO = (Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS, Topic.SERVO_VOLTAGES)
