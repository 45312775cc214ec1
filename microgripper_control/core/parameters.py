"""A physical parameter: its unit, its nominal value and the range in which it makes sense."""

from __future__ import annotations

import math
from dataclasses import dataclass

from microgripper_control.core.errors import MicrogripperError


@dataclass(frozen=True)
class Parameter:
    """One parameter of a link, declared beside the equation that uses it.

    `low` and `high` bound the values a file may hold and a fit may visit. `vanishing` is the value
    at which the effect of the link is gone; it is None for a parameter that merely shapes it. One
    that is not `fitted` is chosen, never estimated by least squares: an exponent, a seed, a
    resolution. Of one that acts `by_sample` a held voltage shows whole samples only.
    """

    name: str
    unit: str
    nominal: float
    low: float
    high: float
    description: str
    vanishing: float | None = None
    fitted: bool = True
    by_sample: bool = False

    def __post_init__(self) -> None:
        if not self.low <= self.nominal <= self.high:
            raise ValueError(f"{self.name}: nominal {self.nominal} outside {self.range_text}")
        if self.vanishing is not None and not self.low <= self.vanishing <= self.high:
            raise ValueError(f"{self.name}: vanishing {self.vanishing} outside {self.range_text}")

    @property
    def range_text(self) -> str:
        """The allowed range as people write it, e.g. `0 .. 1 s`."""
        return f"{self.low:g} .. {self.high:g}{self.suffix}"

    @property
    def suffix(self) -> str:
        """The unit as it follows a number: a space and the unit, nothing for a mere number."""
        return "" if self.unit == "1" else f" {self.unit}"

    def nearest(self, value: float) -> float:
        """The value itself if it is allowed, else the bound that it is past."""
        return min(self.high, max(self.low, value))

    def check(self, value: float, where: str) -> float:
        """Return `value`, or raise MicrogripperError naming `where` and the allowed range."""
        if not math.isfinite(value) or not self.low <= value <= self.high:
            raise MicrogripperError(
                f"{where}: {self.name} = {value:g} is outside its range {self.range_text}"
            )
        return value
