"""The graph of hamr_bringup.graph under `ros2 launch`: the same nodes with the same parameters as `hamr up`.

ros2 launch hamr_bringup hamr.launch.py backend:=full seconds:=5.0
ros2 launch hamr_bringup hamr.launch.py backend:=residual residual:=model.onnx policy:=walk.onnx command:=forward bag:=out/walk
"""

from dataclasses import fields

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from hamr_bringup.graph import Run, graph, run_of_words


def nodes(context: LaunchContext) -> list:
    words = {field.name: LaunchConfiguration(field.name).perform(context) for field in fields(Run)}
    actions = []
    for spec in graph(run_of_words(words)):
        node = Node(package=spec.package, executable=spec.executable, name=spec.name, ros_arguments=spec.arguments()[1:], output="screen")
        actions.append(node)
        if spec.ends_run:
            over = EmitEvent(event=Shutdown(reason="the run is over"))
            actions.append(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=[over])))
    return actions


def generate_launch_description() -> LaunchDescription:
    arguments = [DeclareLaunchArgument(field.name, default_value="", description="see hamr_bringup.graph.Run") for field in fields(Run)]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes)])
