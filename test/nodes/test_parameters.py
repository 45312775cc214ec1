from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from ros_arguments import ros_arguments

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.share import share_folder
from microgripper_control.nodes.parameters import (
    accept_whole_numbers,
    declare_flag,
    declare_number,
    declare_path,
    declare_text,
    declare_texts,
    model_path,
)

GAIN = Parameter("gain", "V/m", 2.0, 0.0, 10.0, "some gain")

MakeNode = Callable[..., Node]


@pytest.fixture
def node(ros: Callable[..., None]) -> Iterator[MakeNode]:
    """A node with parameters as given on the command line."""
    made: list[Node] = []

    def make(**given: str) -> Node:
        ros(*ros_arguments(given))
        made.append(rclpy.create_node("tested"))
        accept_whole_numbers(made[-1])
        return made[-1]

    yield make
    for one in made:
        one.destroy_node()


def refusal(node: Node, name: str, kind: RosParameter.Type, value: object) -> str:
    """Why a parameter may not be set; empty if it may."""
    (result,) = node.set_parameters([RosParameter(name, kind, value)])
    return str(result.reason)


def test_a_whole_number_is_as_good_as_a_float(node: MakeNode) -> None:
    tested = node(gain="5")
    value = declare_number(tested, GAIN)
    assert (value, type(value)) == (5.0, float)
    assert refusal(tested, "gain", RosParameter.Type.INTEGER, 7) == ""
    assert tested.get_parameter("gain").value == 7.0
    assert tested.get_parameter("gain").type_ is RosParameter.Type.DOUBLE


def test_a_parameter_says_what_it_is(node: MakeNode) -> None:
    tested = node()
    assert declare_number(tested, GAIN) == 2.0
    descriptor = tested.describe_parameter("gain")
    assert descriptor.description == "some gain, V/m"
    (extent,) = descriptor.floating_point_range
    assert (extent.from_value, extent.to_value) == (0.0, 10.0)


@pytest.mark.parametrize("value", [-1.0, 10.5, math.nan, math.inf])
def test_out_of_range_is_refused_while_running(node: MakeNode, value: float) -> None:
    tested = node()
    declare_number(tested, GAIN)
    assert "gain" in refusal(tested, "gain", RosParameter.Type.DOUBLE, value)
    assert tested.get_parameter("gain").value == 2.0


def test_a_text_is_no_number_while_running(node: MakeNode) -> None:
    tested = node()
    declare_number(tested, GAIN)
    assert "DOUBLE" in refusal(tested, "gain", RosParameter.Type.STRING, "much")


@pytest.mark.parametrize(
    ("given", "message"),
    [("11", r"gain = 11 is outside its range 0 \.\. 10 V/m"), ("much", "'much' is not a number")],
)
def test_bad_numbers_are_refused_at_the_start(node: MakeNode, given: str, message: str) -> None:
    tested = node(gain=given)
    with pytest.raises(MicrogripperError, match=message):
        declare_number(tested, GAIN)


def test_other_types_are_checked_too(node: MakeNode) -> None:
    tested = node(mode="sideways", flag="3", names="[1, 2]")
    with pytest.raises(MicrogripperError, match="mode: 'sideways' is none of up, down"):
        declare_text(tested, "mode", "up", "", choices=("up", "down"))
    with pytest.raises(MicrogripperError, match="flag"):
        declare_flag(tested, "flag", True, "")
    with pytest.raises(MicrogripperError, match=r"names: \[1, 2\] is not a list of texts"):
        declare_texts(tested, "names", ["a"], "")


def test_a_path_may_begin_with_a_home(node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/somebody")
    made = node(out="~/run", other="~nobody-of-this-name/run")
    assert declare_path(made, "out", "", "") == Path("/home/somebody/run")
    with pytest.raises(MicrogripperError, match="other: '~nobody-of-this-name/run'"):
        declare_path(made, "other", "", "")


def test_a_list_may_be_empty(node: MakeNode) -> None:
    assert declare_texts(node(names="[]"), "names", ["a"], "") == []


def test_a_model_file_may_be_one_of_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert model_path("apa120s.yaml") == share_folder() / "config" / "apa120s.yaml"
    own = tmp_path / "apa120s.yaml"
    own.touch()
    assert model_path("apa120s.yaml").resolve() == own
    assert str(model_path("unknown.yaml")) == "unknown.yaml"


@pytest.mark.parametrize("name", ["m" * 300, "~nobody_of_that_name/model.yaml"])
def test_a_name_that_no_file_can_have_is_refused(name: str) -> None:
    with pytest.raises(MicrogripperError, match="model_file: "):
        model_path(name)
