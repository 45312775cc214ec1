"""Displacement and residual over the voltage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import Diagnosis, Judged
from microgripper_control.identification.nuisance import Mask
from microgripper_control.report.decimation import packed, path
from microgripper_control.report.diagnosis_layers import INK, MICRO, NANO, Layer, gap_bands
from microgripper_control.report.figure_data import Figure, lines, series
from microgripper_control.report.residual_views import over_voltage

LOOP_SHARE = 24  # of a curve's values, the buckets of a loop


def loops(
    diagnosis: Diagnosis, judged: Judged, each: Sequence[Layer], voltage: Array, values: int
) -> dict[str, Figure]:
    """Displacement over voltage, as it is and without the straight line that fits it best."""
    measured = judged.recording.measured
    gain, zero = map(float, np.polyfit(voltage, measured, 1))
    corners = path([voltage, measured, measured - gain * voltage], values // LOOP_SHARE)
    at = voltage[corners]
    shared = {
        "across": packed(at),
        "times": packed(judged.recording.sample_period * corners.astype(np.float64)),
        "bands": gap_bands(diagnosis, "voltage_V"),
        "box": True,
    }
    found = {}
    for name, label, line in (
        ("loops", "displacement", np.zeros(len(at))),
        ("hysteresis", "displacement off the straight line", gain * at + zero),
    ):
        y = packed(MICRO * (measured[corners] - line))
        drawn = [series("measured", INK, None, y, width=2.2)]
        for layer in each:
            y = packed(MICRO * (getattr(judged, layer.field)[corners] - line))
            drawn.append(series(layer.name, layer.colour, None, y, hidden=layer.hidden))
        found[name] = {**lines(("voltage", "V"), (label, "µm"), drawn), **shared}
    return found


def directions(
    diagnosis: Diagnosis,
    voltage: Array,
    pair: Sequence[tuple[Layer, Array]],
    counts: Mask,
) -> Figure | None:
    """Mean residual while the voltage rises and while it falls, before and after."""
    drawn = []
    for each, residual in pair:
        for rising, direction, dash in ((True, "rising", ""), (False, "falling", "5 3")):
            middle, mean = over_voltage(residual, voltage, counts, rising)
            if len(middle) < 2:
                continue
            x, y = packed(middle), packed(NANO * mean)
            drawn.append(series(f"{each.name}, {direction}", each.colour, x, y, dash=dash))
    if not drawn:
        return None
    return lines(
        ("voltage", "V"),
        ("mean residual", "nm"),
        drawn,
        bands=gap_bands(diagnosis, "voltage_V"),
        levels=[{"y": 0.0, "name": ""}],
    )
