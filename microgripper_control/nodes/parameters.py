"""Declaring parameters of nodes: description, unit and range are those of the core's Parameter.

A whole number is as good as a float: rclpy takes `kp: 5` for an integer and would refuse it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rcl_interfaces.srv import ListParameters
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.share import share_folder

Checked = TypeVar("Checked")

QOS = "qos_overrides."  # before the names of what ROS 2 declares with each topic
MODEL_FILE = "apa120s.yaml"
MODEL_FILE_TEXT = "YAML model: a path, or the name of a file in the package's config folder"


def declare_number(node: Node, parameter: Parameter, *, read_only: bool = False) -> float:
    """Declare a floating-point parameter; MicrogripperError if the value given is out of range."""
    name = parameter.name
    # Declared without a type first: an integer in its place would otherwise be an error.
    anything = ParameterDescriptor(dynamic_typing=True)
    given = node.declare_parameter(name, parameter.nominal, anything).value
    node.undeclare_parameter(name)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise MicrogripperError(f"{name}: {given!r:.60} is not a number")
    unit = "" if parameter.unit == "1" else f", {parameter.unit}"
    descriptor = ParameterDescriptor(
        description=f"{parameter.description}{unit}",
        floating_point_range=[
            FloatingPointRange(from_value=float(parameter.low), to_value=float(parameter.high))
        ],
        read_only=read_only,
    )
    value = parameter.check(float(given), "parameter")
    node.declare_parameter(name, value, descriptor, ignore_override=True)
    return value


def declare_numbers(node: Node, parameters: Iterable[Parameter]) -> dict[str, float]:
    """Declare several floating-point parameters; their values by name."""
    return {parameter.name: declare_number(node, parameter) for parameter in parameters}


def declare_text(
    node: Node,
    name: str,
    default: str,
    description: str,
    *,
    choices: Sequence[str] = (),
    read_only: bool = False,
) -> str:
    """Declare a text; MicrogripperError where it is none of the `choices`, if there are any."""
    allowed = f"one of: {', '.join(choices)}" if choices else ""
    value = str(_declare(node, name, default, description, allowed, read_only=read_only))
    check_choice(name, value, choices)
    return value


def declare_path(node: Node, name: str, default: str, description: str) -> Path:
    """Declare a path that cannot be changed while the node runs; `~` is somebody's home."""
    text = declare_text(node, name, default, description, read_only=True)
    return expanded(name, text)


def expanded(name: str, text: str) -> Path:
    """The path that the value of a parameter means; MicrogripperError if there is no such home."""
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise MicrogripperError(f"{name}: {text!r:.60}: {error!s:.120}") from None


def declare_flag(
    node: Node, name: str, default: bool, description: str, *, read_only: bool = False
) -> bool:
    """Declare a parameter that is true or false."""
    return bool(_declare(node, name, default, description, read_only=read_only))


def declare_texts(node: Node, name: str, default: Sequence[str], description: str) -> list[str]:
    """Declare a list of texts; it cannot be changed while the node runs."""
    # Without a type: rclpy cannot tell of which type an empty list is.
    given = _declare(node, name, list(default), description, dynamic_typing=True, read_only=True)
    if given is None:  # what rclpy makes of an empty list in YAML
        return []
    if isinstance(given, (str, bytes)) or not isinstance(given, Sequence):
        raise MicrogripperError(f"{name}: {given!r:.60} is not a list of texts")
    if not all(isinstance(text, str) for text in given):
        raise MicrogripperError(f"{name}: {list(given)!r:.60} is not a list of texts")
    return list(given)


def check_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Raise MicrogripperError naming the choices where `value` is none of them."""
    if choices and value not in choices:
        raise MicrogripperError(f"{name}: {value!r:.60} is none of {', '.join(choices)}")


def parameter_names(node: Node) -> list[str]:
    """The names of all parameters that a node has declared."""
    return list(node.list_parameters([], ListParameters.Request.DEPTH_RECURSIVE).names)


def given_parameters(node: Node) -> frozenset[str]:
    """The names of the parameters that whoever started a node has given, its own or not."""
    return frozenset(node._parameter_overrides)  # rclpy has no other list of them


def unknown_parameters(node: Node) -> list[str]:
    """A line for each parameter that was given and is none of the node's: rclpy ignores it."""
    lines = []
    for name in sorted(given_parameters(node)):
        if node.has_parameter(name) or name.startswith(QOS):
            continue
        near = get_close_matches(name, parameter_names(node), n=1)
        hint = f"did you mean {near[0]}?" if near else "see --help"
        lines.append(f"{name}: there is no such parameter, it is ignored; {hint}")
    return lines


def accept_whole_numbers(node: Node) -> None:
    """Let an integer be set, while the node runs, where a floating-point parameter is."""

    def wanted(given: RosParameter) -> RosParameter:
        kinds = RosParameter.Type
        if given.type_ is not kinds.INTEGER or not node.has_parameter(given.name):
            return given
        if node.get_parameter(given.name).type_ is not kinds.DOUBLE:
            return given
        return RosParameter(given.name, kinds.DOUBLE, float(given.value))

    node.add_pre_set_parameters_callback(lambda given: [wanted(one) for one in given])


def follow_changes(
    node: Node,
    names: Collection[str],
    check: Callable[[dict[str, Any]], Checked],
    apply: Callable[[Checked], None],
) -> None:
    """Have changes of some parameters, made while the node runs, checked and then applied.

    What `check` raises as MicrogripperError is the reason of the refusal, and nothing is changed;
    what it returns goes to `apply` once the parameters are set.
    """
    checked: list[Checked] = []

    def before(given: list[RosParameter]) -> SetParametersResult:
        checked.clear()
        changes = {one.name: one.value for one in given if one.name in names}
        try:
            if changes:
                checked.append(check(changes))
        except MicrogripperError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def after(given: list[RosParameter]) -> None:
        if checked:
            apply(checked.pop())

    node.add_on_set_parameters_callback(before)
    node.add_post_set_parameters_callback(after)


def model_path(name: str) -> Path:
    """The file that a `model_file` parameter means; a path that exists comes first.

    MicrogripperError where no file can have that name.
    """
    path = expanded("model_file", name)
    try:
        if path.exists() or path.is_absolute():
            return path
        packaged = share_folder() / "config" / path
        return packaged if packaged.is_file() else path
    except OSError as error:  # too long a name
        raise MicrogripperError(f"model_file: {name!r:.60}: {error!s:.120}") from None


def _declare(
    node: Node,
    name: str,
    default: object,
    description: str,
    constraints: str = "",
    **descriptor: object,
) -> Any:  # noqa: ANN401 (a parameter's value is of any type)
    full = ParameterDescriptor(
        description=description, additional_constraints=constraints, **descriptor
    )
    try:
        return node.declare_parameter(name, default, full).value
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise MicrogripperError(str(error)) from None
