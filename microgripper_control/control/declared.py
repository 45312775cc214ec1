"""Frozen settings whose fields are declared parameters: unit, range and description beside them.

    @dataclass(frozen=True)
    class Gains(Declared):
        kp: float = declared("V/m", 0.0, 0.0, 1e12, "proportional gain")

The declaration is the field's default, the check at construction and what a ROS node declares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from numbers import Real
from typing import Any, TypeVar

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter

Settings = TypeVar("Settings", bound="Declared")


def declared(
    unit: str, nominal: float, low: float, high: float, description: str, *, whole: bool = False
) -> Any:  # noqa: ANN401 (as dataclasses.field: the field's own annotation is the type)
    """A float field of a `Declared` class with its Parameter; `whole` asks for a whole number."""
    metadata = {"range": (unit, low, high, description), "whole": whole}
    return field(default=nominal, metadata=metadata)


@dataclass(frozen=True)
class Declared:
    """Checks its declared fields at construction; MicrogripperError names field and range."""

    def __post_init__(self) -> None:
        where = type(self).__name__
        for parameter in self.parameters():
            value = _number(getattr(self, parameter.name), f"{where}: {parameter.name}")
            if parameter.name in self._whole() and not value.is_integer():
                raise MicrogripperError(
                    f"{where}: {parameter.name} = {value:g} must be a whole number"
                )
            object.__setattr__(self, parameter.name, parameter.check(value, where))
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(entry.default, bool) and not isinstance(value, bool):
                raise MicrogripperError(
                    f"{where}: {entry.name}: {value!r:.60} is not true or false"
                )

    @classmethod
    @cache
    def parameters(cls) -> tuple[Parameter, ...]:
        """The declared fields, in order."""
        found = []
        for entry in fields(cls):
            if "range" in entry.metadata:
                unit, low, high, description = entry.metadata["range"]
                assert isinstance(entry.default, (int, float))
                found.append(Parameter(entry.name, unit, entry.default, low, high, description))
        return tuple(found)

    @classmethod
    @cache
    def _whole(cls) -> frozenset[str]:
        return frozenset(entry.name for entry in fields(cls) if entry.metadata.get("whole"))

    @classmethod
    def from_values(cls: type[Settings], values: Mapping[str, Any], where: str) -> Settings:
        """Make one of plain values, the others at their defaults.

        Raises MicrogripperError that begins with `where` for an unknown key or a bad value.
        """
        known = [entry.name for entry in fields(cls)]
        for name in values:
            if name not in known:
                raise MicrogripperError(
                    f"{where}: unknown key {name!r}; known are {', '.join(known)}"
                )
        try:
            return cls(**values)
        except MicrogripperError as error:
            raise MicrogripperError(f"{where}: {error}") from None


def _number(given: object, where: str) -> float:
    """A whole number is as good as a float; a truth value or text is not a number."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise MicrogripperError(f"{where}: {given!r:.60} is not a number")
    try:
        return float(given)
    except OverflowError:
        raise MicrogripperError(f"{where}: {given!r:.60} is too large") from None
