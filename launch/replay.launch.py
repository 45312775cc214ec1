"""Replay against the model: the voltage of a recording drives the simulated rig, sample by sample.

With `out` the answer is recorded: what the model makes of the voltage the real rig got.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, RegisterEventHandler, Shutdown
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import (
    LaunchConfiguration,
    NotEqualsSubstitution,
    PathJoinSubstitution,
    PythonExpression,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "microgripper_control"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start player and plant; they end with the recording."""
    config = PathJoinSubstitution([FindPackageShare(PACKAGE), "config"])
    common = {
        "package": PACKAGE,
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    file = LaunchConfiguration("params_file")
    out = LaunchConfiguration("out")

    def partners(name: str) -> PythonExpression:
        """With a recorder they wait for it, too, so that the bag begins with the first sample."""
        return PythonExpression(["['", name, "'] + ['recorder'] * bool('", out, "')"])

    player = Node(
        executable="player",
        ros_arguments=enclave("player"),
        parameters=[
            file,
            # As it stands: YAML would make a date of 2026-07-01.
            {"recording": ParameterValue(LaunchConfiguration("recording"), value_type=str)},
            {"pace": "samples"},
            {"partners": partners("plant_simulator")},
        ],
        **common,
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument(
                "params_file", default_value=PathJoinSubstitution([config, "microgripper.yaml"])
            ),
            DeclareLaunchArgument("recording", description="bag or CSV"),
            DeclareLaunchArgument("out", default_value="", description="folder of the new bag"),
            player,
            Node(
                executable="recorder",
                ros_arguments=enclave("recorder"),
                parameters=[file, {"out": ParameterValue(out, value_type=str)}],
                condition=IfCondition(NotEqualsSubstitution(out, "")),
                **common,
            ),
            Node(
                executable="plant_simulator",
                ros_arguments=enclave("plant_simulator"),
                parameters=[file, {"lockstep": True, "partners": partners("player")}],
                **common,
            ),
            # The recording has ended, or one of the nodes has failed.
            RegisterEventHandler(OnProcessExit(on_exit=[Shutdown(reason="a node has ended")])),
        ]
    )
