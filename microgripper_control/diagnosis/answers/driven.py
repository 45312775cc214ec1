"""How much of a gap follows from the voltage: what an effect takes away that knows nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from microgripper_control.diagnosis.findings import Candidate
from microgripper_control.effects.base import no_courses
from microgripper_control.effects.registry import registry


def most_driven(found: Sequence[Candidate]) -> Candidate | None:
    """The effect that takes most away and knows the voltage alone; None if none takes any."""
    driven = [one for one in found if one.stage is not None and _knows_the_voltage_alone(one)]
    return max(driven, key=lambda one: one.share, default=None)


def _knows_the_voltage_alone(candidate: Candidate) -> bool:
    """Not so what has a course in each recording, which may take up what it did not cause."""
    link = registry()[candidate.effect]
    return candidate.share > 0.0 and link.courses is no_courses and not link.read_off
