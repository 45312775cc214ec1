"""Which code an examination is of."""

from __future__ import annotations

import hashlib

from microgripper_control.core.compiled import PACKAGE, add_sources


def sources() -> str:
    """A hash of all of the package's sources, as they are now."""
    digest = hashlib.sha256()
    add_sources(digest, PACKAGE)
    return digest.hexdigest()[:16]
