"""Values as a page's script unpacks them."""

from __future__ import annotations

import base64

import numpy as np

from microgripper_control.core.signals import Array


def unpacked(found: dict[str, object]) -> Array:
    raw = base64.b64decode(str(found["base64"]))
    scale = float(str(found["low"])) + float(str(found["step"])) * np.frombuffer(raw, "<u2")
    return np.power(10.0, scale) if found["log"] else scale
