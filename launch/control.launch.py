"""The control loop: controller and reference, and the simulated rig unless there is a real one.

With `watch:=true` the diagnoser runs beside it.
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "microgripper_control"
AS_IN_THE_FILE = "if given, in place of what the file of parameters says"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start the loop; `simulate:=false` where a driver publishes joint_states."""
    usual = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "microgripper.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument("params_file", default_value=usual),
            DeclareLaunchArgument("simulate", default_value="true"),
            DeclareLaunchArgument("lockstep", default_value="", description=AS_IN_THE_FILE),
            DeclareLaunchArgument(
                "mode",
                default_value="",
                description=f"{AS_IN_THE_FILE}; open_loop: with quantity: voltage of the "
                "reference there, or reference:=false and a voltage_setpoint of your own",
            ),
            DeclareLaunchArgument("reference", default_value="true"),
            DeclareLaunchArgument("watch", default_value="false"),
            OpaqueFunction(function=nodes),
        ]
    )


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes: an argument that was given counts more than the file of parameters."""
    in_step = LaunchConfiguration("lockstep")
    given = in_step.perform(context)
    lockstep = [{"lockstep": ParameterValue(in_step, value_type=bool)}] if given else []
    law = LaunchConfiguration("mode").perform(context)
    mode = [{"mode": law}] if law else []
    common = {
        "package": PACKAGE,
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    file = LaunchConfiguration("params_file")
    return [
        Node(
            executable="plant_simulator",
            ros_arguments=enclave("plant_simulator"),
            parameters=[file, *lockstep],
            condition=IfCondition(LaunchConfiguration("simulate")),
            **common,
        ),
        Node(
            executable="controller",
            ros_arguments=enclave("controller"),
            parameters=[file, *lockstep, *mode],
            **common,
        ),
        Node(
            executable="reference",
            ros_arguments=enclave("reference"),
            parameters=[file],
            condition=IfCondition(LaunchConfiguration("reference")),
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
