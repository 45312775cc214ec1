"""The control loop: controller and reference, and the simulated rig unless there is a real one.

With `watch:=true` the diagnoser runs beside it.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "microgripper_control"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start the loop; `simulate:=false` where a driver publishes joint_states."""
    usual = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "microgripper.yaml"])
    lockstep = {"lockstep": ParameterValue(LaunchConfiguration("lockstep"), value_type=bool)}
    mode = {"mode": LaunchConfiguration("mode")}
    common = {
        "package": PACKAGE,
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    file = LaunchConfiguration("params_file")
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument("params_file", default_value=usual),
            DeclareLaunchArgument("simulate", default_value="true"),
            DeclareLaunchArgument("lockstep", default_value="false"),
            DeclareLaunchArgument("mode", default_value="cascade"),
            DeclareLaunchArgument("watch", default_value="false"),
            Node(
                executable="plant_simulator",
                ros_arguments=enclave("plant_simulator"),
                parameters=[file, lockstep],
                condition=IfCondition(LaunchConfiguration("simulate")),
                **common,
            ),
            Node(
                executable="controller",
                ros_arguments=enclave("controller"),
                parameters=[file, lockstep, mode],
                **common,
            ),
            Node(
                executable="reference",
                ros_arguments=enclave("reference"),
                parameters=[file],
                **common,
            ),
            Node(
                executable="diagnoser",
                ros_arguments=enclave("diagnoser"),
                parameters=[file],
                condition=IfCondition(LaunchConfiguration("watch")),
                **common,
            ),
        ]
    )
