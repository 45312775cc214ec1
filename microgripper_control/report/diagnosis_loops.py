"""Displacement and residual over the voltage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import Diagnosis, Judged
from microgripper_control.identification.nuisance import Mask
from microgripper_control.report.decimation import packed, path
from microgripper_control.report.diagnosis_layers import INK, MICRO, NANO, Layer, gap_bands
from microgripper_control.report.figure_data import Figure, height, lines, series
from microgripper_control.report.residual_views import over_voltage

LOOP_SHARE = 24  # of a curve's values, the buckets of a loop


def loops(
    diagnosis: Diagnosis,
    judged: Judged,
    each: Sequence[Layer],
    voltage: Array,
    values: int,
    counts: Mask,
) -> dict[str, Figure]:
    """Displacement over voltage, as it is and without the straight line that fits it best."""
    measured = judged.recording.measured
    gain, zero = map(float, np.polyfit(voltage[counts], measured[counts], 1))
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
        ("loops", "displacement", np.zeros(len(voltage))),
        ("hysteresis", "displacement off the straight line", gain * voltage + zero),
    ):
        drawn = [_course("measured", INK, measured - line, corners, counts, width=2.2)]
        for layer in each:
            off = getattr(judged, layer.field) - line
            drawn.append(
                _course(layer.name, layer.colour, off, corners, counts, hidden=layer.hidden)
            )
        found[name] = {**lines(("voltage", "V"), (label, "µm"), drawn), **shared}
    return found


def _course(
    name: str,
    colour: str,
    displacement: Array,
    corners: NDArray[np.int64],
    counts: Mask,
    **style: object,
) -> Figure:
    micro = MICRO * displacement
    return series(name, colour, None, packed(micro[corners]), height=height(micro[counts]), **style)


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
