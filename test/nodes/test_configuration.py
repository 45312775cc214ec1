"""The files of config/ and launch/ say nothing that the nodes do not know."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from rcl_interfaces.srv import ListParameters
from rclpy.qos import ReliabilityPolicy

from microgripper_control.core.share import share_folder
from microgripper_control.nodes.controller import ControllerNode
from microgripper_control.nodes.diagnoser import Diagnoser
from microgripper_control.nodes.identifier import Identifier
from microgripper_control.nodes.plant_simulator import PlantSimulator
from microgripper_control.nodes.player import Player
from microgripper_control.nodes.recorder import Recorder
from microgripper_control.nodes.reference import Reference
from microgripper_control.nodes.shell import Shell
from microgripper_control.plant.model_file import load_model

ROOT = share_folder()
LAUNCH_FILES = sorted((ROOT / "launch").glob("*.launch.py"))
PARAMETER_FILES = [ROOT / "config" / name for name in ("microgripper.yaml", "experiment.yaml")]
NODES: dict[str, type[Shell]] = {
    "plant_simulator": PlantSimulator,
    "controller": ControllerNode,
    "reference": Reference,
    "recorder": Recorder,
    "player": Player,
    "identifier": Identifier,
    "diagnoser": Diagnoser,
}


def flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested parameters by their full names."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


@pytest.fixture
def make(
    ros: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[..., Shell]]:
    """Makes a node in the test's process, with arguments as on the command line."""
    monkeypatch.chdir(tmp_path)
    made: list[Shell] = []

    def make(name: str, *args: str) -> Shell:
        ros("--ros-args", *args)
        made.append(NODES[name]())
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


@pytest.mark.parametrize("file", PARAMETER_FILES, ids=lambda file: file.name)
def test_every_parameter_in_a_file_is_one_of_its_node(
    make: Callable[..., Shell], file: Path
) -> None:
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    for pattern, section in content.items():
        name = pattern.removeprefix("/**/")
        node = make(name, "--params-file", str(file))
        for parameter, value in flat(section["ros__parameters"]):
            assert node.has_parameter(parameter), f"{file.name}: {name} has no {parameter}"
            assert node.get_parameter(parameter).value == value, f"{file.name}: {parameter}"


def test_the_usual_file_says_what_the_nodes_do_without_it(make: Callable[..., Shell]) -> None:
    content = yaml.safe_load(PARAMETER_FILES[0].read_text(encoding="utf-8"))
    for pattern, section in content.items():
        node = make(pattern.removeprefix("/**/"))
        own = {"low", "high"} if pattern.endswith("reference") else set()
        for parameter, value in flat(section["ros__parameters"]):
            if parameter not in own:
                assert node.get_parameter(parameter).value == value, f"{pattern}: {parameter}"


@pytest.mark.parametrize("name", NODES)
def test_every_parameter_says_what_it_is(make: Callable[..., Shell], name: str) -> None:
    node = make(name)
    names = node.list_parameters([], ListParameters.Request.DEPTH_RECURSIVE).names
    assert len(names) > 3
    for parameter in set(names) - {"use_sim_time", "start_type_description_service"}:
        assert node.describe_parameter(parameter).description, parameter


def test_the_models_can_be_read() -> None:
    paper = load_model(ROOT / "config" / "apa120s.yaml")
    maker = load_model(ROOT / "config" / "apa120s_datasheet.yaml")
    assert paper.voltage_range == (0.0, 160.0)
    assert maker.voltage_range == (-20.0, 150.0)


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_launch_files_start_what_there_is_with_parameters_that_there_are(
    make: Callable[..., Shell], file: Path
) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert "generate_launch_description" in functions
    dictionaries = {
        target.id: part
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign)
        for part in ast.walk(node.value)
        if isinstance(part, ast.Dict)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    started = 0
    for call in ast.walk(tree):
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)):
            continue
        if call.func.id != "Node":
            continue
        arguments = {word.arg: word.value for word in call.keywords if word.arg}
        executable = ast.literal_eval(arguments["executable"])
        node = make(executable)
        started += 1
        for part in ast.walk(arguments["parameters"]):
            given = dictionaries.get(part.id) if isinstance(part, ast.Name) else part
            for key in given.keys if isinstance(given, ast.Dict) else []:
                assert isinstance(key, ast.Constant)
                assert node.has_parameter(key.value), f"{executable} has no {key.value}"
    assert started


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_launch_files_refer_to_files_and_arguments_that_there_are(file: Path) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    calls = [n for n in ast.walk(tree) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)]

    def first_arguments(function: str) -> set[str]:
        return {
            call.args[0].value
            for call in calls
            if call.func.id == function and isinstance(call.args[0], ast.Constant)  # type: ignore[attr-defined]
        }

    assert first_arguments("LaunchConfiguration") == first_arguments("DeclareLaunchArgument")
    texts = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)}
    for name in (text for text in texts if isinstance(text, str) and text.endswith(".yaml")):
        assert (ROOT / "config" / name).is_file(), name


def test_topics_can_be_remapped_and_their_quality_overridden(make: Callable[..., Shell]) -> None:
    quality = "qos_overrides./rig/samples.publisher"
    node = make(
        "plant_simulator",
        *("-r", "__ns:=/rig", "-r", "joint_states:=samples"),
        *("-p", f"{quality}.depth:=7", "-p", f"{quality}.reliability:=best_effort"),
    )
    assert isinstance(node, PlantSimulator)
    node.trigger_configure()
    (samples,) = (one for one in node.publishers if one.topic_name == "/rig/samples")
    assert samples.qos_profile.depth == 7
    assert samples.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT


@pytest.mark.parametrize(("rate", "deadline"), [(1000.0, 0.1), (5.0, 1.0)])
def test_no_deadline_is_offered_that_the_rate_does_not_keep(
    make: Callable[..., Shell], rate: float, deadline: float
) -> None:
    node = make("plant_simulator", "-p", f"sample_rate:={rate}")
    assert isinstance(node, PlantSimulator)
    node.trigger_configure()
    (samples,) = (one for one in node.publishers if one.topic_name.endswith("/joint_states"))
    assert samples.qos_profile.deadline.nanoseconds == round(1e9 * deadline)
