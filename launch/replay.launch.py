"""Replay against the model: the voltage of a recording drives the simulated rig, sample by sample.

The rig begins at the first voltage and ends with the last one. With `out` the answer is recorded:
what the model makes of the voltage the real rig got.
"""

from pathlib import Path

from launch import Action, LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from microgripper_control.recordings.read import read_recording

PACKAGE = "microgripper_control"


def enclave(node: str) -> list[str]:
    """Where the node finds its rights, if security is on: see docs/security.md."""
    return ["--enclave", f"/microgripper/{node}"]


def generate_launch_description() -> LaunchDescription:
    """Start player and plant; they end with the recording."""
    config = PathJoinSubstitution([FindPackageShare(PACKAGE), "config"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="microgripper"),
            DeclareLaunchArgument(
                "params_file", default_value=PathJoinSubstitution([config, "microgripper.yaml"])
            ),
            DeclareLaunchArgument("recording", description="bag or CSV"),
            DeclareLaunchArgument("out", default_value="", description="folder of the new bag"),
            OpaqueFunction(function=nodes),
        ]
    )


def nodes(context: LaunchContext) -> list[Action]:
    """The nodes; they wait for a recorder, too, so that the bag begins with the first sample."""
    out = LaunchConfiguration("out")
    wanted = out.perform(context) != ""
    recorders = ["recorder"] if wanted else []
    common = {
        "package": PACKAGE,
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    file = LaunchConfiguration("params_file")
    # As they stand: YAML would make a date of 2026-07-01.
    recording = ParameterValue(LaunchConfiguration("recording"), value_type=str)
    answer = ParameterValue(out, value_type=str)
    played = read_recording(
        Path(LaunchConfiguration("recording").perform(context)), needs_displacement=False
    )
    recorder = Node(
        executable="recorder",
        ros_arguments=enclave("recorder"),
        parameters=[file, {"out": answer}],
        **common,
    )
    return [
        Node(
            executable="player",
            ros_arguments=enclave("player"),
            parameters=[
                file,
                {"recording": recording, "pace": "samples"},
                {"partners": ["plant_simulator", *recorders]},
            ],
            **common,
        ),
        *([recorder] if wanted else []),
        Node(
            executable="plant_simulator",
            ros_arguments=enclave("plant_simulator"),
            parameters=[
                file,
                {"lockstep": True, "partners": ["player", *recorders]},
                {
                    "sample_rate": 1.0 / played.sample_period,
                    "initial_voltage": float(played.voltage[0]),
                    "duration": len(played) * played.sample_period,
                },
            ],
            **common,
        ),
        # The recording has ended, or one of the nodes has failed.
        RegisterEventHandler(OnProcessExit(on_exit=[Shutdown(reason="a node has ended")])),
    ]
