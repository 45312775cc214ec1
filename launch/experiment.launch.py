"""A recorded experiment: the control loop and the recorder; it ends when the setpoints end."""

from launch import Action, LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, Shutdown
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "microgripper_control"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start the loop; `out` is the folder of the bag."""
    config = PathJoinSubstitution([FindPackageShare(PACKAGE), "config"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument(
                "params_file", default_value=PathJoinSubstitution([config, "microgripper.yaml"])
            ),
            DeclareLaunchArgument(
                "experiment_file", default_value=PathJoinSubstitution([config, "experiment.yaml"])
            ),
            DeclareLaunchArgument("out", description="folder of the bag, a new one"),
            DeclareLaunchArgument("simulate", default_value="true"),
            DeclareLaunchArgument(
                "lockstep",
                default_value="",
                description="if given, in place of what the files of parameters say",
            ),
            OpaqueFunction(function=nodes),
        ]
    )


def nodes(context: LaunchContext) -> list[Action]:
    """The nodes: an argument that was given counts more than the files of parameters."""
    in_step = LaunchConfiguration("lockstep")
    given = in_step.perform(context)
    lockstep = [{"lockstep": ParameterValue(in_step, value_type=bool)}] if given else []
    common = {
        "package": PACKAGE,
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    files = [LaunchConfiguration("params_file"), LaunchConfiguration("experiment_file")]
    # As it stands: YAML would make a date of 2026-07-01.
    out = ParameterValue(LaunchConfiguration("out"), value_type=str)
    return [
        Node(
            executable="recorder",
            ros_arguments=enclave("recorder"),
            parameters=[*files, {"out": out}],
            **common,
        ),
        Node(
            executable="plant_simulator",
            ros_arguments=enclave("plant_simulator"),
            parameters=[*files, *lockstep],
            condition=IfCondition(LaunchConfiguration("simulate")),
            **common,
        ),
        Node(
            executable="controller",
            ros_arguments=enclave("controller"),
            parameters=[*files, *lockstep],
            **common,
        ),
        Node(
            executable="reference", ros_arguments=enclave("reference"), parameters=files, **common
        ),
        # The setpoints have ended, or a node has failed, for which the others would wait.
        RegisterEventHandler(OnProcessExit(on_exit=[Shutdown(reason="a node has ended")])),
    ]
