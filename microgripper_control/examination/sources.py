"""Which code an examination is of."""

from __future__ import annotations

import hashlib
from functools import cache

from microgripper_control.core.compiled import PACKAGE, add_sources


@cache
def sources() -> str:
    """A hash of all of the package's sources, as they were when it was first asked for."""
    digest = hashlib.sha256()
    add_sources(digest, PACKAGE)
    return digest.hexdigest()[:16]
