"""How a voltage runs between its samples."""

from __future__ import annotations

import enum


class Hold(str, enum.Enum):
    """Held from each sample to the next, straight from one to the next, or band-limited."""

    ZERO = "zero"
    FIRST = "first"
    BANDLIMITED = "bandlimited"
