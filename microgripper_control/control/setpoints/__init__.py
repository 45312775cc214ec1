"""What the loop is to follow: setpoints by name, and the factory that makes one of plain values."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from microgripper_control.control.setpoints.base import Ranged, Setpoint
from microgripper_control.control.setpoints.excitations import Chirp, Multisine
from microgripper_control.control.setpoints.recorded import Recorded, read_recorded
from microgripper_control.control.setpoints.sequence import Sequence
from microgripper_control.control.setpoints.shapes import Ramp, Sine, Staircase, Step, Triangle
from microgripper_control.core.errors import MicrogripperError

__all__ = [
    "SETPOINTS",
    "Chirp",
    "Multisine",
    "Ramp",
    "Recorded",
    "Sequence",
    "Setpoint",
    "Sine",
    "Staircase",
    "Step",
    "Triangle",
    "make_setpoint",
    "read_recorded",
]

# Those that their declared parameters describe in full.
SETPOINTS: Mapping[str, type[Ranged]] = MappingProxyType(
    {
        "step": Step,
        "staircase": Staircase,
        "ramp": Ramp,
        "triangle": Triangle,
        "sine": Sine,
        "multisine": Multisine,
        "chirp": Chirp,
    }
)


def make_setpoint(name: str, values: Mapping[str, Any], where: str = "setpoint") -> Setpoint:
    """The setpoint of that name, parameters not given at their defaults.

    Raises MicrogripperError that begins with `where` for an unknown name or a bad value.
    """
    if name not in SETPOINTS:
        raise MicrogripperError(f"{where}: unknown {name!r}; known are {', '.join(SETPOINTS)}")
    return SETPOINTS[name].from_values(values, where)
