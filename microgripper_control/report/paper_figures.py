"""Figures of the paper's sections 3 to 6: the model, its parameters, and its inverse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from microgripper_control.control.feedforward import InverseKind
from microgripper_control.paper.behaviour import BehaviourResult, safe_spans
from microgripper_control.paper.identification import IdentificationResult
from microgripper_control.paper.inverse import FAST, InverseResult
from microgripper_control.paper.printed import TABLE_2
from microgripper_control.paper.stiffness import StiffnessResult
from microgripper_control.report.figures import (
    FOURTH,
    MEASURED,
    SIMULATED,
    THIRD,
    figure,
    label,
)

VOLTAGE, DISPLACEMENT, TIME = "voltage (V)", "displacement (µm)", "time (s)"
PLANE = 0.05  # 1/V, of the map of beta and gamma
PLANE_POINTS = 41
SPANS = (160.0, 225.0, 300.0)  # V, of the contours
LABELS = ((-31.0, 5.0), (-22.0, 5.0), (-16.5, 4.0))  # 1/kV, about where their labels stand


def draw_behaviour(result: BehaviourResult, path: Path) -> None:
    """The classes over beta and gamma, and loops within the safe range and beyond."""
    with figure(path, (9.0, 4.2)) as drawn:
        plane, loops = drawn.subplots(1, 2, width_ratios=(1.0, 1.1))
        _plane(plane, result)
        for (span, loop), colour in zip(
            result.loops.items(), (MEASURED, THIRD, SIMULATED), strict=True
        ):
            loops.plot(
                loop.voltage, 1e6 * loop.displacement, color=colour, label=f"0 to {span:g} V"
            )
        loops.legend(loc="upper left")
        label(loops, VOLTAGE, DISPLACEMENT, "Settled cycles, Table 1")


def _plane(axes: Axes, result: BehaviourResult) -> None:
    p = 1e3 * PLANE
    areas = (
        ("#dcebdd", ((0, 0), (-p, p), (p, p)), "class I"),
        ("#eef5d8", ((0, 0), (p, p), (p, 0)), "class II"),
        ("#fbe9d7", ((0, 0), (-p, p), (-p, 0)), "h grows\nwith the\nvoltage"),
        ("#f6d5d5", ((-p, 0), (p, 0), (p, -p), (-p, -p)), "h grows with every movement"),
    )
    for colour, corners, _ in areas:
        axes.add_patch(Polygon(np.array(corners, dtype=float), color=colour, zorder=0))
    for (x, y), (_, _, name) in zip(
        ((0.0, 40.0), (32.0, 12.0), (-42.0, 7.0), (0.0, -12.0)), areas, strict=True
    ):
        axes.text(x, y, name, ha="center", va="center", fontsize=8, color="#444444")
    axis = np.linspace(-PLANE, PLANE, PLANE_POINTS)
    spans = safe_spans(result.model, axis[axis >= 0.0], axis)
    lines = axes.contour(
        1e3 * axis,
        1e3 * axis[axis >= 0.0],
        np.minimum(spans, 1e4),
        levels=SPANS,
        colors="#666666",
        linewidths=0.9,
    )
    axes.clabel(lines, fmt="%g V", fontsize=7, manual=LABELS)
    values = result.model.values("bouc_wen")
    for name, point, colour, offset in (
        ("Table 1", values, MEASURED, (4, 7)),
        ("Table 2", TABLE_2, SIMULATED, (8, -2)),
    ):
        at = (1e3 * point["gamma"], 1e3 * point["beta"])
        axes.plot(*at, "o", color=colour, markersize=5, zorder=3)
        axes.annotate(name, at, offset, textcoords="offset points", fontsize=8, color=colour)
    axes.grid(False)
    axes.set(xlim=(-p, p), ylim=(-0.5 * p, p))
    label(axes, "gamma (1/kV)", "beta (1/kV)", "Class of the operator; lines: safe range")


def draw_stiffness(result: StiffnessResult, path: Path) -> None:
    """Fig. 4: force and displacement with the regression."""
    with figure(path, (6.0, 4.0)) as drawn:
        axes = drawn.subplots()
        axes.plot(
            1e6 * result.displacement,
            result.force,
            "o",
            markersize=4,
            label="stand-in: linear elastic, with scatter",
        )
        line = 1e6 * result.fit.displacement(result.force)
        low, high = result.fit.interval
        axes.plot(
            line,
            result.force,
            label=f"k = {1e-5 * result.fit.value:.2f}e5 N/m"
            f" ({1e-5 * low:.2f} to {1e-5 * high:.2f})",
        )
        axes.legend(loc="upper left")
        label(axes, DISPLACEMENT, "force (N)")


def draw_identification(result: IdentificationResult, path: Path) -> None:
    """Fig. 7: measured with the paper's sensor, and the model found, over time."""
    recording = result.paper.recording
    with figure(path, (8.0, 5.0)) as drawn:
        above, below = drawn.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        above.plot(recording.time, 1e6 * recording.measured, label="rig, 1 µm sensor")
        above.plot(recording.time, 1e6 * result.prediction, "--", label="identified model")
        above.legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, 1.18))
        label(above, "", DISPLACEMENT)
        error = 1e6 * (recording.measured - result.prediction)
        below.plot(recording.time, error, color=FOURTH, linewidth=0.7)
        label(below, TIME, "difference (µm)")


def draw_loop(result: IdentificationResult, path: Path) -> None:
    """Fig. 8: the hysteresis loop of the model found."""
    recording = result.paper.recording
    # x[k] answers to u[k-1].
    voltage, displacement = recording.voltage[:-1], result.prediction[1:]
    first = np.argmax(voltage)
    with figure(path, (6.0, 4.3)) as drawn:
        axes = drawn.subplots()
        axes.plot(
            voltage,
            1e6 * recording.measured[1:],
            color="#9db4cc",
            linewidth=0.8,
            label="rig, 1 µm sensor",
        )
        axes.plot(voltage, 1e6 * displacement, color=SIMULATED, label="identified model")
        axes.plot(voltage[:first], 1e6 * displacement[:first], color=THIRD, label="first rise")
        axes.legend(loc="upper left")
        label(axes, VOLTAGE, DISPLACEMENT)


def draw_inverse(result: InverseResult, path: Path) -> None:
    """Fig. 10: the voltage that was applied, and the one the inverse model finds."""
    found = result.paper
    time, voltage = found.recording.time[:-1], found.recording.voltage[:-1]
    with figure(path, (8.0, 5.0)) as drawn:
        above, below = drawn.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        above.plot(time, voltage, label="applied")
        above.plot(
            time,
            found.predicted,
            "--",
            linewidth=1.0,
            label="inverse model of the displacement read with 1 µm",
        )
        above.legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, 1.18))
        label(above, "", VOLTAGE)
        below.plot(time, voltage - found.predicted, color=FOURTH, linewidth=0.7)
        label(below, TIME, "difference (V)")


def draw_compensators(result: InverseResult, path: Path) -> None:
    """Where equation (6) is better and where the exact discrete inverse."""
    names = {InverseKind.PAPER: "equation (6), explicit", InverseKind.EXACT: "exact inverse"}
    with figure(path, (6.5, 4.0)) as drawn:
        axes = drawn.subplots()
        periods = 1e6 * np.array(result.fast_periods)
        for kind, name in names.items():
            axes.loglog(periods, result.fast_errors[kind], "o-", markersize=4, label=name)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")
        for crossing in result.crossings:
            axes.axvline(1e6 * crossing, color="#7b8794", linestyle=":")
        axes.legend(loc="lower right")
        label(
            axes,
            "sample period (µs)",
            "error (% rms of peak to peak)",
            f"Compensators at {FAST:g} Hz, parameters of Table 1",
        )
