"""The residual as a map over displacement and the rate of the voltage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.identification.nuisance import Mask
from microgripper_control.report.diagnosis_layers import MICRO, NANO, Layer
from microgripper_control.report.figure_data import Figure
from microgripper_control.report.residual_views import COLUMNS, Grid
from microgripper_control.report.wording import MINUS, number

RATES = 10.0 ** np.arange(-6, 9)  # V/s, where the map may have a tick
TICK_DISTANCE = 0.08  # of the map's height, at least
SEEN = 0.98  # of the cells lie within the colours
SMALLEST_LIMIT = 1e-3  # nm


def residual_map(
    diagnosis: Diagnosis,
    grid: Grid,
    pair: Sequence[tuple[Layer, Array]],
    counts: Mask,
) -> Figure:
    """Mean residual of each cell, before and after, in the same colours."""
    means = [NANO * grid.mean(residual, counts) for _, residual in pair]
    seen = np.abs(np.concatenate([mean[np.isfinite(mean)] for mean in means]))
    limit = float(np.quantile(seen, SEEN)) if len(seen) else 1.0
    return {
        "kind": "map",
        "x": {
            "label": "displacement",
            "unit": "µm",
            "low": MICRO * grid.low,
            "high": MICRO * grid.high,
            "bands": [
                [MICRO * found.low, MICRO * found.high]
                for found in diagnosis.where
                if found.axis == "displacement_m"
            ],
        },
        "y": {
            "label": "voltage rate",
            "unit": "V/s",
            "ticks": _rate_ticks(grid),
        },
        "unit": "nm",
        "limit": max(limit, SMALLEST_LIMIT),
        "columns": COLUMNS,
        "panels": [
            {"name": each.name, "values": _cells(mean)}
            for (each, _), mean in zip(pair, means, strict=True)
        ],
    }


def _cells(mean: Array) -> list[float | None]:
    return [round(value, 2) if np.isfinite(value) else None for value in mean.ravel().tolist()]


def _rate_ticks(grid: Grid) -> list[tuple[float, str]]:
    """Zero and the powers of ten, as many as find room."""
    ticks, last = [(0.5, "0")], 0.5
    for rate in RATES:
        at = grid.position(float(rate))
        if at <= 1.0 and at - last >= TICK_DISTANCE:
            text = number(float(rate), 1)
            ticks += [(at, text), (1.0 - at, f"{MINUS}{text}")]
            last = at
    return ticks
