"""Finds the links: every module in a stage folder that defines `LINK`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from microgripper_control import effects
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.effects.base import Link, Stage


@lru_cache(maxsize=1)
def registry() -> Mapping[str, Link]:
    """All links by name, in the order of the chain.

    Raises ValueError for a module without `LINK`, a name given twice, or a link in another stage's
    folder: mistakes of whoever adds one, shown at once.
    """
    found: dict[str, Link] = {}
    for stage in Stage:
        folder = importlib.import_module(f"{effects.__name__}.{stage.value}")
        for entry in pkgutil.iter_modules(folder.__path__, f"{folder.__name__}."):
            link = getattr(importlib.import_module(entry.name), "LINK", None)
            if not isinstance(link, Link):
                raise ValueError(f"{entry.name} defines no LINK")
            if link.stage is not stage:
                raise ValueError(f"{entry.name}: stage {link.stage.value} in folder {stage.value}")
            if link.name in found:
                raise ValueError(f"{entry.name}: the name {link.name} is taken")
            found[link.name] = link
    return MappingProxyType(dict(sorted(found.items(), key=lambda item: item[1].place)))


def link_named(name: str, where: str = "model") -> Link:
    """The link of that name; MicrogripperError lists the known ones if there is none."""
    try:
        return registry()[name]
    except KeyError:
        known = ", ".join(registry())
        raise MicrogripperError(f"{where}: unknown link {name!r}; known are {known}") from None
