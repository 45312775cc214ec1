"""Finds the effects: every module in this folder that defines `EFFECT`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.validation import effects
from microgripper_control.validation.effects.form import STAGES, Effect, Form


@lru_cache(maxsize=1)
def known_effects() -> Mapping[str, Effect]:
    """All effects by name, in the order of the signal chain and then of the alphabet."""
    found = []
    for entry in pkgutil.iter_modules(effects.__path__, f"{effects.__name__}."):
        effect = getattr(importlib.import_module(entry.name), "EFFECT", None)
        if isinstance(effect, Effect):
            found.append(effect)
    found.sort(key=lambda effect: (STAGES.index(effect.stage), effect.name))
    return MappingProxyType({effect.name: effect for effect in found})


def in_library(yes: bool) -> tuple[str, ...]:
    """Names of the effects that a diagnosis has a candidate for, or of those it never has."""
    return tuple(name for name, effect in known_effects().items() if effect.in_library == yes)


def form_of(effect: str, form: str) -> Form:
    """One form; MicrogripperError lists what there is if there is none of that name."""
    if effect not in known_effects():
        known = ", ".join(known_effects())
        raise MicrogripperError(f"rig: unknown effect {effect!r}; known are {known}")
    forms = {one.name: one for one in known_effects()[effect].forms}
    if form not in forms:
        raise MicrogripperError(f"rig: {effect} has no form {form!r}; it has {', '.join(forms)}")
    return forms[form]
