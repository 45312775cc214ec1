"""The gains that nobody gave follow the model and the sample rate; those given stay."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter as RosParameter
from ros_arguments import ros_arguments
from running_nodes import Start, Watcher

from microgripper_control.control.controller import Controller
from microgripper_control.control.tuning import default_gains
from microgripper_control.nodes.controller import ControllerNode
from microgripper_control.nodes.controller_settings import load_identified
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.simulate import Plant

Make = Callable[..., ControllerNode]


@pytest.fixture
def make(ros: Callable[..., None]) -> Iterator[Make]:
    """A controller that is configured, with parameters as given on the command line."""
    made: list[ControllerNode] = []

    def make(**given: object) -> ControllerNode:
        ros(*ros_arguments({"autostart": "false", **given}))
        node = ControllerNode()
        made.append(node)
        node.begin()
        node.trigger_configure()
        return node

    yield make
    for node in made:
        node.leave()
        node.destroy_node()


@pytest.fixture
def late(tmp_path: Path) -> tuple[Model, str]:
    """A model that answers 5 ms late, and its file."""
    model, path = nominal_model().with_link("transport_delay", delay=5e-3), tmp_path / "late.yaml"
    save_model(model, path)
    return model, str(path)


def change(node: ControllerNode, **values: object) -> str:
    """Change parameters of a node while it runs; the reason why not."""
    wanted = [RosParameter(name, value=value) for name, value in values.items()]
    return str(node.set_parameters_atomically(wanted).reason)


def swing(controller: Controller, plant: Plant) -> float:
    """How far the displacement moves once it was to stand at 8 um for long, m."""
    voltage, read = controller.start(0.0), []
    for _ in range(800):
        read.append(plant.read())
        plant.write(voltage)
        voltage = controller.step(8e-6, read[-1], voltage)
    return float(max(read[-200:]) - min(read[-200:]))


def controller_of(node: ControllerNode) -> Controller:
    assert node._controller is not None
    return node._controller


def test_a_model_that_answers_late_gets_gains_of_its_own(
    make: Make, late: tuple[Model, str]
) -> None:
    node = make()
    first = node.value_of("ki")
    model, path = late
    assert change(node, model_file=path) == ""
    suited = default_gains(load_identified(path), 1e-3)
    assert controller_of(node).gains == suited
    assert node.value_of("ki") == suited.ki < 0.5 * first  # the parameter says what is at work
    assert swing(controller_of(node), Plant(model, 1e-3)) < 1e-8
    assert change(node, model_file="apa120s.yaml") == ""
    assert node.value_of("ki") == controller_of(node).gains.ki == first


def test_the_rate_has_its_gains_too(make: Make) -> None:
    node = make(mode="pid")
    node.trigger_cleanup()
    assert change(node, sample_rate=100.0) == ""
    node.trigger_configure()
    suited = default_gains(load_identified("apa120s.yaml"), 1e-2)
    assert controller_of(node).gains == suited
    assert node.value_of("ki") == suited.ki
    assert swing(controller_of(node), Plant(nominal_model(), 1e-2)) < 1e-8


@pytest.mark.parametrize("when", ["at the start", "while it runs"])
def test_a_gain_that_was_given_stays(make: Make, late: tuple[Model, str], when: str) -> None:
    given: dict[str, Any] = {"ki": 2e8, "kp": 1e3}
    node = make(**given) if when == "at the start" else make()
    if when == "while it runs":
        assert change(node, **given) == ""
        assert change(node, ki=-1.0) != ""  # what was refused counts for nothing
    assert change(node, model_file=late[1]) == ""
    gains = controller_of(node).gains
    assert (gains.ki, gains.kp, gains.kd) == (2e8, 1e3, 0.0)
    assert (node.value_of("ki"), node.value_of("kp")) == (2e8, 1e3)


def test_given_as_it_was_a_gain_is_given(make: Make, late: tuple[Model, str]) -> None:
    node = make()
    ki = node.value_of("ki")
    assert change(node, ki=ki) == ""
    assert change(node, model_file=late[1]) == ""
    assert controller_of(node).gains.ki == ki


def test_a_model_that_no_gains_suit_is_refused_until_some_are_given(
    make: Make, tmp_path: Path
) -> None:
    values = {("second_order", "m"): 0.05, ("second_order", "b"): 0.0}
    path = tmp_path / "undamped.yaml"
    save_model(nominal_model().with_values(values), path)
    node = make()
    assert "give gains" in change(node, model_file=str(path))
    assert node.value_of("model_file") == "apa120s.yaml"
    assert change(node, model_file=str(path), ki=1e6) == ""
    assert controller_of(node).gains.ki == 1e6


def test_a_change_of_gains_moves_no_voltage(make: Make, late: tuple[Model, str]) -> None:
    node = make(mode="pid")
    controller, plant = controller_of(node), Plant(nominal_model(), 1e-3)
    voltages = [controller.start(0.0)]
    for tick in range(300):
        if tick == 200:
            assert change(node, model_file=late[1]) == ""
        read = plant.read()
        plant.write(voltages[-1])
        voltages.append(controller.step(8e-6, read, voltages[-1]))
    assert voltages[200] > 10.0
    assert max(voltages[200:]) - min(voltages[200:]) < 1e-3


@pytest.mark.ros
def test_gains_that_the_loop_does_not_bear_are_told(
    start: Start, watcher: Watcher, late: tuple[Model, str]
) -> None:
    reports = watcher.messages(DiagnosticArray, "/diagnostics")
    node = start("controller", model_file=late[1], ki=2.3e9)
    unstable = "by the model the loop is unstable with kp = 0, ki = 2.3e+09, kd = 0"
    node.until_it_says(unstable)
    watcher.until(
        lambda: any(status.message == unstable for one in reports for status in one.status),
        "the warning in /diagnostics",
    )
    assert node.stop() == 0


def test_only_a_loop_is_unstable(make: Make, late: tuple[Model, str]) -> None:
    node = make(model_file=late[1], ki=2.3e9)
    assert "unstable" in node._settings.warning
    assert change(node, mode="feedforward") == ""
    assert node._settings.warning == ""
    assert change(node, mode="pid", ki=2e8) == ""
    assert node._settings.warning == ""
