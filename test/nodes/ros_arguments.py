"""How a node's parameters stand on its command line."""

from __future__ import annotations

from collections.abc import Mapping


def ros_arguments(parameters: Mapping[str, object]) -> list[str]:
    """`--ros-args` and a `-p name:=value` for each; nothing for none."""
    words = [word for pair in parameters.items() for word in ("-p", "{}:={}".format(*pair))]
    return ["--ros-args", *words] if words else []
