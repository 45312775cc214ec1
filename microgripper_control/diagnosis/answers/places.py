"""Where a gap lies, in words: what each axis is called, and how a range on it is put."""

from __future__ import annotations

from typing import NamedTuple

from microgripper_control.core.quantities import percent, quantity, span
from microgripper_control.diagnosis.findings import Range


class Axis(NamedTuple):
    """What an axis is called, its unit, and how a range of it is put after a verb."""

    name: str
    unit: str
    phrase: str


AXES = {
    "frequency_Hz": Axis("frequency", "Hz", "at frequencies {}"),
    "displacement_m": Axis("displacement", "m", "at displacements {}"),
    "voltage_V": Axis("voltage", "V", "at voltages {}"),
    "rate_V_per_s": Axis("voltage rate", "V/s", "while the voltage changes by {}"),
    "time_s": Axis("time", "s", "{} into"),
    "hold_time_s": Axis("time at rest", "s", "{} after the voltage has come to rest"),
    "direction": Axis("direction", "1", "{}"),
}


def where(found: Range) -> str:
    """Where a part of the gap lies, as a sentence."""
    return as_sentence(clause(found, "the gap's"))


def as_sentence(said: str) -> str:
    """A clause as a sentence by itself."""
    return f"{said[0].upper()}{said[1:]}."


def clause(found: Range, whose: str) -> str:
    """The same within a sentence, where the gap is what is `whose`."""
    held = f"{percent(found.share_of_gap)} of {whose} power lies"
    if found.bend is None:
        return f"{held} {place(found)}"
    side = "above" if found.bend == found.low else "below"
    at = quantity(found.bend, AXES[found.axis].unit)
    return f"{side} {at} the error takes another slope; {held} there"


def place(found: Range) -> str:
    """Where a range lies, to be read after a verb."""
    if found.axis == "direction":
        if found.low < 0.0 < found.high:
            return "on rising and falling voltage alike"
        return f"on {'rising' if found.high > 0.0 else 'falling'} voltage"
    axis = AXES[found.axis]
    text = span(found.low, found.high, axis.unit)
    if axis.phrase.startswith("at") and not text.startswith(("above", "below")):
        text = f"of {text}"
    said = axis.phrase.format(text)
    return f"{said} {found.recording or 'the recording'}" if found.axis == "time_s" else said
