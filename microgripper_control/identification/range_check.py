"""Whether the recordings stay within the voltages that the model's values hold for."""

from __future__ import annotations

from collections.abc import Sequence

from microgripper_control.core.recording import Recording
from microgripper_control.plant.model import Model


def range_warnings(nominal: Model, recordings: Sequence[Recording]) -> list[str]:
    """One line for each recording that goes beyond."""
    beyond = [(one.name, nominal.beyond(one.voltage)) for one in recordings]
    return [f"{name}: {what}" for name, what in beyond if what]
