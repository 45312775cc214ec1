"""What a node says of itself on `--help`: its parameters as they are declared."""

from __future__ import annotations

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from microgripper_control.nodes.parameters import QOS, parameter_names

WORDS = ("-h", "--help")
SYNTAX = "--ros-args [-p NAME:=VALUE ...] [--params-file FILE] [-r __ns:=/NAMESPACE]"


def usage(node: Node) -> str:
    """How the node is called and, a line each, its parameters with what they are for."""
    names = sorted(name for name in parameter_names(node) if not name.startswith(QOS))
    lines = [f"usage: {node.get_name()} {SYNTAX}", "", "parameters:"]
    for name in names:
        described, value = node.describe_parameter(name), node.get_parameter(name).value
        lines.append(f"  {name} (now {value!r})")
        lines += [f"      {text}" for text in _told(described)]
    return "\n".join(lines)


def _told(described: ParameterDescriptor) -> list[str]:
    """Its description and what restricts it, as far as there is any."""
    ranges = (*described.floating_point_range, *described.integer_range)
    restricted = [f"{one.from_value:g} .. {one.to_value:g}" for one in ranges]
    restricted += [described.additional_constraints] if described.additional_constraints else []
    restricted += ["read only"] if described.read_only else []
    text = "; ".join([described.description, *restricted])
    return [text] if text else []
