"""Which column or topic of other people's recordings holds which quantity: the option `--map`.

    --map voltage=COLUMN_OR_TOPIC[:FIELD][*SCALE]

`FIELD` picks a number out of a message, e.g. `position[0]`, `data` or `wrench.force.z`; `SCALE`
brings it to SI units, e.g. `*1e-6` for micrometres.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from microgripper_control.core.errors import MicrogripperError

QUANTITIES = ("voltage", "displacement", "setpoint", "time")
FORM = "expected QUANTITY=COLUMN_OR_TOPIC[:FIELD][*SCALE]"

_WORD = r"[A-Za-z_]\w*(\[\d+\])?"
_FIELD = re.compile(rf"{_WORD}(\.{_WORD})*")


@dataclass(frozen=True)
class Source:
    """Where one quantity comes from; its values are multiplied by `scale`."""

    name: str  # of a column or a topic
    field: str | None = None  # of the topic's messages
    scale: float = 1.0

    @property
    def column(self) -> str:
        """The name as a CSV column: there a colon is a character like any other."""
        return self.name if self.field is None else f"{self.name}:{self.field}"


@dataclass(frozen=True)
class Mapping:
    """The source of each quantity; None means the usual column or topic."""

    voltage: Source | None = None
    displacement: Source | None = None
    setpoint: Source | None = None
    time: Source | None = None  # CSV only: in a bag the messages are stamped

    @classmethod
    def parse(cls, texts: Sequence[str]) -> Mapping:
        """Parse the values of all `--map` options; MicrogripperError quotes the bad one."""
        sources: dict[str, Source] = {}
        for text in texts:
            quantity, equals, rest = text.partition("=")
            quantity = quantity.strip()
            if not equals:
                raise MicrogripperError(f"--map {text}: {FORM}")
            if quantity not in QUANTITIES:
                raise MicrogripperError(
                    f"--map {text}: unknown quantity {quantity!r}; known are "
                    + ", ".join(QUANTITIES)
                )
            if quantity in sources:
                raise MicrogripperError(f"--map {text}: {quantity} is mapped twice; give it once")
            sources[quantity] = _source(text, rest.strip())
        return cls(**sources)


DEFAULT_MAPPING = Mapping()


def _source(text: str, rest: str) -> Source:
    scale = 1.0
    if "*" in rest:
        rest, _, factor = rest.rpartition("*")
        try:
            scale = float(factor)
        except ValueError:
            raise MicrogripperError(f"--map {text}: scale {factor!r} is not a number") from None
        if not math.isfinite(scale) or scale == 0.0:
            raise MicrogripperError(f"--map {text}: scale {factor} must be finite and not 0")
    name, colon, field = rest.strip().rpartition(":")
    if not colon or not _FIELD.fullmatch(field):
        name, field = rest.strip(), ""
    if not name:
        raise MicrogripperError(f"--map {text}: no column or topic is named; {FORM}")
    if name.startswith("/") and ":" in name:
        raise MicrogripperError(f"--map {text}: the field is not of the form a.b[0].c")
    return Source(name, field or None, scale)
