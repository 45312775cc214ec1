"""The simulated rig alone: something to send voltage_command to and to read joint_states from."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "microgripper_control"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start the plant."""
    usual = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "microgripper.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument("params_file", default_value=usual),
            Node(
                package=PACKAGE,
                executable="plant_simulator",
                ros_arguments=enclave("plant_simulator"),
                namespace=LaunchConfiguration("namespace"),
                parameters=[LaunchConfiguration("params_file")],
                output="screen",
            ),
        ]
    )
