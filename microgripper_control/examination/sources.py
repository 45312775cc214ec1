"""Which code an examination is of."""

from __future__ import annotations

import hashlib
from functools import cache

from microgripper_control.core.compiled import PACKAGE


@cache
def sources() -> str:
    """A hash of all of the package's sources, as they were when it was first asked for."""
    digest = hashlib.sha256()
    for source in sorted(PACKAGE.rglob("*.py")):
        digest.update(str(source.relative_to(PACKAGE)).encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]
