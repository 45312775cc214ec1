"""Whether what a diagnosis named could pass for the cause, asked of the rig's own laws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from microgripper_control.diagnosis.findings import EFFECTS
from microgripper_control.validation.case import Case
from microgripper_control.validation.effects.registry import known_effects
from microgripper_control.validation.rivals import rival
from microgripper_control.validation.strengths import excess
from microgripper_control.validation.truth import SEEN

AGREE = excess(SEEN)  # over the noise: a smaller difference between two laws cannot be seen


def agree(difference: float | None) -> bool:
    """Whether two laws agree within the noise, from what the second leaves beyond the first."""
    return difference is not None and difference <= AGREE


def groups_with(diagnosis: Mapping[str, Any], effect: str) -> list[list[str]]:
    """The other members of each group of the diagnosis that an effect is in."""
    groups = diagnosis["ambiguous"]
    return [[name for name in group if name != effect] for group in groups if effect in group]


def rivals_of(case: Case, diagnosis: Mapping[str, Any]) -> dict[str, float | None]:
    """What the laws of named effects leave beyond the cause's own, over the noise.

    Asked of the effect that stands first in the answer if it is not the cause, and of all that are
    named as ambiguous with the cause until one differs. None where it cannot be told.
    """
    seen = [cause.effect for cause in case.truth.causes if cause.seen]
    if len(case.truth.causes) != 1 or not seen or diagnosis["verdict"] != EFFECTS:
        return {}
    cause = seen[0]
    found = {}
    first = diagnosis["effects"][0]
    if first != cause:
        found[first] = _excess(case, first)
    for name in (name for group in groups_with(diagnosis, cause) for name in group):
        if name not in found:
            found[name] = _excess(case, name)
        if not agree(found[name]):
            break
    return found


def _excess(case: Case, effect: str) -> float | None:
    if effect not in known_effects():
        return None
    try:
        other = rival(case, effect)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None
    return other.excess if other else None
