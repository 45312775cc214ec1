"""The figures of a diagnosis: what is drawn of each judging recording.

Displacements are in µm, residuals in nm, all else in SI.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import Diagnosis, Judged, NextExperiment
from microgripper_control.identification.nuisance import Mask
from microgripper_control.report.decimation import packed
from microgripper_control.report.diagnosis_layers import (
    AFTER,
    GREY,
    INK,
    MICRO,
    NANO,
    Layer,
    gap_bands,
    layers,
)
from microgripper_control.report.diagnosis_loops import directions, loops
from microgripper_control.report.diagnosis_map import residual_map
from microgripper_control.report.figure_data import Figure, height, lines, over_time, series
from microgripper_control.report.residual_views import (
    Grid,
    Holds,
    answered_voltage,
    spectrum,
    white_density,
)

VALUES = 300_000  # in all lines over time of a page: they are nearly all of its size
CURVES = 12  # of such a size, of a recording
MOST, FEWEST = 16_384, 1_000  # values of a curve
SHORT_BREAK = 0.01  # of a recording


def recording_figures(diagnosis: Diagnosis, judged: Judged) -> dict[str, Figure | None]:
    """The figures of one recording by name; None for one that it has no data for."""
    each = layers(diagnosis)
    recording = judged.recording
    counts = diagnosis.conditions.answered(recording)
    voltage = answered_voltage(recording, diagnosis.conditions.hold)
    values = min(max(VALUES // (CURVES * len(diagnosis.judged)), FEWEST), MOST)
    residuals = [(layer, layer.residual(judged)) for layer in each]
    pair = residuals[-2:]
    grid = Grid.of(judged.position, voltage, recording.sample_period)
    return {
        **_over_time(diagnosis, judged, residuals, values, counts),
        "spectrum": _spectrum(diagnosis, recording, residuals, counts),
        "map": residual_map(diagnosis, grid, pair, counts),
        "holds": _holds(diagnosis, recording, pair, counts),
        **loops(diagnosis, judged, each, voltage, values, counts),
        "directions": directions(diagnosis, voltage, pair, counts),
    }


def next_figure(experiment: NextExperiment) -> Figure:
    """The voltage of the next experiment."""
    line = over_time("voltage", AFTER, experiment.voltage, experiment.sample_period, MOST)
    return lines(("time", "s"), ("voltage", "V"), [line])


def _over_time(
    diagnosis: Diagnosis,
    judged: Judged,
    residuals: Sequence[tuple[Layer, Array]],
    values: int,
    counts: Mask,
) -> dict[str, Figure | None]:
    recording = judged.recording
    bands = [*_judging_times(judged), *gap_bands(diagnosis, "time_s", recording.name)]

    def line(name: str, colour: str, signal: Array, **style: object) -> Figure:
        return over_time(name, colour, signal, recording.sample_period, values, **style)

    measured = line("measured", INK, MICRO * recording.measured, width=2.2)
    simulated = [
        line(each.name, each.colour, MICRO * getattr(judged, each.field), hidden=each.hidden)
        for each, _ in residuals
    ]
    left = [
        line(
            each.name,
            each.colour,
            NANO * residual,
            hidden=each.hidden,
            height=height(NANO * residual[counts]),
        )
        for each, residual in residuals
    ]
    time = ("time", "s")
    voltage = line("voltage", GREY, recording.voltage)
    reach = (0.0, recording.sample_period * len(recording))
    options = {"linked": True, "bands": bands, "reach": reach}
    return {
        "response": lines(time, ("displacement", "µm"), [measured, *simulated]) | options,
        "voltage": lines(time, ("voltage", "V"), [voltage], flat=True) | options,
        "residual": lines(time, ("residual", "nm"), left) | options,
    }


def _spectrum(
    diagnosis: Diagnosis,
    recording: Recording,
    residuals: Sequence[tuple[Layer, Array]],
    counts: Mask,
) -> Figure:
    drawn = []
    for each, residual in residuals:
        found = spectrum(residual, counts, recording.sample_period)
        x, y = packed(found.frequency, True), packed(NANO * found.density, True)
        drawn.append(series(each.name, each.colour, x, y, hidden=each.hidden))
    floor = NANO * white_density(diagnosis.gap.noise_floor, recording.sample_period)
    return lines(
        ("frequency", "Hz"),
        ("residual", "nm/√Hz"),
        drawn,
        logarithmic=("x", "y"),
        bands=gap_bands(diagnosis, "frequency_Hz"),
        levels=[{"y": floor, "name": "noise floor, as white noise"}] if floor > 0.0 else [],
    )


def _holds(
    diagnosis: Diagnosis,
    recording: Recording,
    pair: Sequence[tuple[Layer, Array]],
    counts: Mask,
) -> Figure | None:
    holds = Holds.of(recording)
    drawn = []
    for each, residual in pair:
        since, mean = holds.course(residual, counts)
        if len(since) < 3:
            return None
        drawn.append(
            series(each.name, each.colour, packed(since, True), packed(NANO * mean), dots=True)
        )
    return lines(
        ("time since the voltage came to rest", "s"),
        ("residual along the step", "nm"),
        drawn,
        logarithmic=("x",),
        bands=gap_bands(diagnosis, "hold_time_s"),
        levels=[{"y": 0.0, "name": ""}],
    )


def _judging_times(judged: Judged) -> list[Figure]:
    """Where errors are taken; short breaks, of samples that were missed, are passed over."""
    period, length = judged.recording.sample_period, len(judged.recording)
    borders = np.flatnonzero(np.diff(judged.counted.astype(int), prepend=0, append=0))
    begins, ends = borders[::2], borders[1::2]
    apart = begins[1:] - ends[:-1] > SHORT_BREAK * length
    begins, ends = begins[np.append(True, apart)], ends[np.append(apart, True)]
    pairs = zip((period * begins).tolist(), (period * ends).tolist(), strict=True)
    return [{"low": low, "high": high, "kind": "judged", "name": ""} for low, high in pairs]
