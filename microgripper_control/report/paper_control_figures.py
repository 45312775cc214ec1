"""Figures of the paper's sections 7 to 10: the linear model, PID, open loop, and tracking."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from microgripper_control.paper import headline, printed
from microgripper_control.paper.headline import HeadlineResult
from microgripper_control.paper.linearised import LinearisedResult
from microgripper_control.paper.open_loop import EXACT, LINE, LINEARISED, OpenLoopResult
from microgripper_control.paper.pid import ROBUST, ULTIMATE_PI, PidResult
from microgripper_control.report.figures import (
    FOURTH,
    MEASURED,
    SIMULATED,
    THIRD,
    figure,
    label,
)
from microgripper_control.report.paper_figures import DISPLACEMENT, TIME, VOLTAGE

HYSTERESIS = "hysteretic variable h (µm)"
SMALLEST_BAR = 1e-3  # %, what the logarithmic axis begins with


def draw_linear_hysteresis(result: LinearisedResult, path: Path) -> None:
    """Fig. 12 and 13: h over time and over the voltage, and its linear equivalent."""
    time = np.arange(len(result.voltage)) / (len(result.voltage) - 1) * result.fit.cycles
    with figure(path, (9.0, 4.2)) as drawn:
        course, loop = drawn.subplots(1, 2, width_ratios=(1.5, 1.0), sharey=True)
        for values, name, style in (
            (result.hysteresis, "equation (3)", "-"),
            (result.linear_hysteresis, "equation (7), fitted", "--"),
        ):
            course.plot(time / result.fit.frequency, 1e6 * values, style, label=name)
            loop.plot(result.voltage, 1e6 * values, style, linewidth=1.0)
        course.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.12))
        label(course, TIME, HYSTERESIS)
        label(loop, VOLTAGE, "")


def draw_linear_displacement(result: LinearisedResult, path: Path) -> None:
    """Fig. 14: the displacement of the nonlinear and of the linearised model."""
    with figure(path, (6.0, 4.3)) as drawn:
        axes = drawn.subplots()
        for values, name, style in (
            (result.displacement, "nonlinear, equation (3)", "-"),
            (result.linear_displacement, "linearised, equation (7)", "--"),
        ):
            axes.plot(result.voltage, 1e6 * values, style, linewidth=1.2, label=name)
        axes.legend(loc="upper left")
        label(axes, VOLTAGE, DISPLACEMENT)


def draw_frequency(result: LinearisedResult, path: Path) -> None:
    """k1 and k2 over the drive's frequency."""
    frequency = [fit.frequency for fit in result.sweep]
    with figure(path, (8.0, 3.6)) as drawn:
        left, right = drawn.subplots(1, 2)
        left.semilogx(frequency, [1e8 * fit.found.k1 for fit in result.sweep], "o-")
        left.axhline(1e8 * printed.K1, color=SIMULATED, linestyle="--", label="printed")
        left.set_ylim(0.0, 3.0)
        left.legend(loc="lower right")
        label(left, "drive frequency (Hz)", "k1 (1e-8 m/V)")
        right.loglog(frequency, [-fit.found.k2 for fit in result.sweep], "o-", label="fitted")
        right.axhline(-printed.K2, color=SIMULATED, linestyle="--", label="printed")
        right.plot(result.fit.frequency_of_printed_k2, -printed.K2, "o", color=SIMULATED)
        right.legend(loc="lower right")
        label(right, "drive frequency (Hz)", "-k2 (1/s)")
        for axis in (left.xaxis, right.xaxis, right.yaxis):
            axis.set_major_formatter("{x:g}")


def draw_pid(result: PidResult, path: Path) -> None:
    """Fig. 15: the nonlinear plant under two sets of gains, whole and around one step."""
    with figure(path, (9.0, 4.2)) as drawn:
        whole, step = drawn.subplots(1, 2, width_ratios=(1.6, 1.0))
        begin = result.start + 50
        window = slice(begin - 10, begin + 40)
        for axes, part in ((whole, slice(result.start - 50, None)), (step, window)):
            time = result.time[part] if axes is whole else 1e3 * result.time[part]
            axes.step(
                time,
                1e6 * result.setpoint[part],
                ":",
                color="#222222",
                where="post",
                linewidth=1.2,
                label="setpoint",
            )
            for name, colour in ((ULTIMATE_PI, MEASURED), (ROBUST, SIMULATED)):
                moved = result.sets[name].displacement
                assert moved is not None
                axes.plot(
                    time,
                    1e6 * moved[part],
                    color=colour,
                    linewidth=1.1,
                    marker="." if axes is step else "",
                    label=name,
                )
        whole.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, 1.12))
        label(whole, TIME, DISPLACEMENT)
        label(step, "time (ms)", "", "one step")


def draw_open_loop(result: OpenLoopResult, path: Path) -> None:
    """Fig. 16 and 17: the voltage for a required displacement, and what results."""
    found = result.ways[LINEARISED]
    with figure(path, (9.0, 4.2)) as drawn:
        left, right = drawn.subplots(1, 2)
        left.plot(1e6 * found.required, found.voltage)
        label(left, "required displacement (µm)", VOLTAGE, "Fig. 16: linearised model")
        for name, colour in ((LINE, FOURTH), (LINEARISED, MEASURED), (EXACT, THIRD)):
            way = result.ways[name]
            right.plot(
                1e6 * way.required,
                1e6 * (way.resulting - way.required),
                color=colour,
                linewidth=1.1,
                label=f"{name}, slope {way.slope:.3f}",
            )
        right.set_ylim(top=right.get_ylim()[1] + 0.8)
        right.legend(loc="upper left")
        label(right, "required displacement (µm)", "resulting less required (µm)", "Fig. 17")


def draw_headline(result: HeadlineResult, path: Path) -> None:
    """Largest tracking errors by law and case, against the paper's 5 %."""
    with figure(path, (9.0, 4.6)) as drawn:
        axes = drawn.subplots()
        errors = result.errors[headline.MAIN]
        laws = headline.LAWS[:4]
        width = 0.8 / len(laws)
        colours = ("#b5bfca", FOURTH, MEASURED, SIMULATED)
        for index, (law, colour) in enumerate(zip(laws, colours, strict=True)):
            heights = [max(errors[case][law].largest, SMALLEST_BAR) for case in headline.CASES]
            places = np.arange(len(heights)) + (index - 1.5) * width
            axes.bar(places, heights, width, color=colour, label=law)
            for x, case in zip(places, headline.CASES, strict=True):
                value = errors[case][law].largest
                axes.annotate(
                    _short(value),
                    (x, max(value, SMALLEST_BAR)),
                    (0.0, 2.0),
                    textcoords="offset points",
                    ha="center",
                    fontsize=7,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3},
                )
        axes.set_yscale("log")
        axes.set_ylim(SMALLEST_BAR, 100.0)
        axes.yaxis.set_major_formatter("{x:g}")
        axes.axhline(
            printed.ERROR,
            color="#222222",
            linestyle="--",
            linewidth=0.9,
            label='the paper\'s "less than 5 %"',
        )
        axes.set_xticks(range(len(headline.CASES)), [_wrapped(case) for case in headline.CASES])
        axes.grid(False, axis="x")
        axes.set_axisbelow(True)
        axes.legend(loc="upper center", ncols=5, bbox_to_anchor=(0.5, 1.1), fontsize=8)
        label(axes, "", "largest error (% of peak to peak)")


def draw_tracking(result: HeadlineResult, path: Path) -> None:
    """Errors over time of the four laws, plant 10 % off, and with the paper's sensor."""
    with figure(path, (9.0, 4.6)) as drawn:
        panels = drawn.subplots(1, 2, sharey=True)
        for axes, case in zip(panels, (headline.OFF, headline.COARSE), strict=True):
            _errors(axes, result, case)
        handles, names = panels[0].get_legend_handles_labels()
        drawn.legend(handles, names, loc="outside upper center", ncols=4)
        panels[0].set_ylabel("setpoint less displacement (µm)")


def _errors(axes: Axes, result: HeadlineResult, case: str) -> None:
    colours = ("#b5bfca", FOURTH, MEASURED, SIMULATED)
    for law, colour in zip(headline.LAWS[:4], colours, strict=True):
        error = 1e6 * (result.setpoint - result.runs[case][law])
        axes.plot(result.time, error, color=colour, linewidth=1.0, label=law)
    label(axes, TIME, "", case)


def _short(value: float) -> str:
    """A per cent value on a bar."""
    return "~0" if value < SMALLEST_BAR else f"{value:.1f}" if value >= 1.0 else f"{value:.2g}"


def _wrapped(text: str) -> str:
    return text.replace(", ", ",\n")
