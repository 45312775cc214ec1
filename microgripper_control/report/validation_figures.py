"""Figures of an examination."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from microgripper_control.examination.calibration import Reliability
from microgripper_control.examination.others import Method
from microgripper_control.examination.plan import STRENGTHS
from microgripper_control.examination.score import Score
from microgripper_control.examination.shares import Share
from microgripper_control.examination.shrinking import DIAGNOSIS, Errors, closable
from microgripper_control.report.figures import (
    FOURTH,
    MEASURED,
    SIMULATED,
    THIRD,
    figure,
    label,
)
from microgripper_control.report.wording import plain

COLOURS = dict(zip(STRENGTHS, (FOURTH, MEASURED, THIRD), strict=True))
METHOD_COLOURS = (MEASURED, SIMULATED, THIRD, FOURTH)
SHIFT = 0.22  # of a row, between the strengths
WORST = -1.0  # of the closed gap, as drawn


def draw_effects(score: Score, path: Path) -> None:
    """Of each effect: how often it was named, by strength, with intervals."""
    effects = [effect for effect in score.effects if any(s.of for s in effect.top.values())]
    with figure(path, (8.0, 1.6 + 0.32 * len(effects))) as drawn:
        axes = drawn.subplots()
        for index, strength in enumerate(STRENGTHS):
            for row, effect in enumerate(effects):
                height = row + SHIFT * (index - 1)
                _interval(axes, effect.top[strength], height, COLOURS[strength])
            axes.plot([], [], "o", color=COLOURS[strength], label=strength)
        axes.set_yticks(range(len(effects)), [plain(effect.name) for effect in effects])
        axes.set_ylim(len(effects) - 0.4, -0.6)
        axes.set_xlim(-2.0, 102.0)
        axes.legend(
            loc="upper center", ncols=3, bbox_to_anchor=(0.5, 1.0 + 0.9 / (len(effects) + 1))
        )
        label(axes, "named (%), with 95 % intervals", "")


def _interval(axes: Axes, share: Share, height: float, colour: str) -> None:
    if not share.of:
        return
    low, high = share.interval
    axes.plot([100.0 * low, 100.0 * high], [height, height], color=colour, lw=1.0)
    axes.plot(100.0 * share.value, height, "o", color=colour, markersize=4)


def draw_matrix(score: Score, path: Path) -> None:
    """What was answered to what was asked."""
    found = score.matrix
    rows = [i for i, row in enumerate(found.counts) if sum(row)]
    counts = np.array([found.counts[i] for i in rows], float).reshape(len(rows), len(found.said))
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    with figure(path, (9.5, 2.6 + 0.3 * len(rows))) as drawn:
        axes = drawn.subplots()
        axes.grid(False)
        if not rows:
            axes.set_axis_off()
            axes.text(0.5, 0.5, "no single cause was asked for", ha="center")
            return
        axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.3, aspect="auto")
        for i, j in zip(*np.nonzero(counts), strict=True):
            axes.text(j, i, f"{counts[i, j]:g}", ha="center", va="center", fontsize=7)
        axes.set_xticks(range(len(found.said)), [plain(name) for name in found.said], rotation=60)
        for tick in axes.get_xticklabels():
            tick.set_horizontalalignment("right")
            tick.set_rotation_mode("anchor")
        axes.set_yticks(range(len(rows)), [plain(found.asked[i]) for i in rows])
        axes.tick_params(labelsize=8)
        label(axes, "answered", "true")


def draw_reliability(score: Score, path: Path) -> None:
    """How often what was given with some probability came true."""
    with figure(path, (8.0, 3.9)) as drawn:
        left, right = drawn.subplots(1, 2, sharey=True)
        _diagram(left, score.probability, "probability of the answer")
        _diagram(right, score.present, "present, each effect of each case")
        left.set_ylabel("came true (%)")


def _diagram(axes: Axes, found: Reliability, what: str) -> None:
    axes.plot([0.0, 100.0], [0.0, 100.0], "--", color="#b5bfca", lw=1.0)
    for one in found.bins:
        low, high = one.share.interval
        x = 100.0 * one.mean
        axes.plot([x, x], [100.0 * low, 100.0 * high], color=MEASURED, lw=1.0)
        axes.plot(x, 100.0 * one.share.value, "o", color=MEASURED, markersize=5)
        axes.annotate(
            str(one.share.of),
            (x, 100.0 * one.share.value),
            (5.0, -9.0),
            textcoords="offset points",
            fontsize=7,
            color="#51606f",
        )
    axes.set(xlim=(-3.0, 103.0), ylim=(-3.0, 103.0))
    label(axes, "given (%)", "", f"{what}: error {found.error:.3f}")


def draw_errors(score: Score, path: Path) -> None:
    """Held-out errors before and after, and what part of the gap each method closes."""
    errors = closable(score.cases)
    with figure(path, (9.0, 4.0)) as drawn:
        left, right = drawn.subplots(1, 2)
        _before_and_after(left, errors)
        for method, colour in zip(score.methods, METHOD_COLOURS, strict=True):
            _closed(right, method, errors, colour)
        right.axvline(100.0, color="#b5bfca", lw=1.0, linestyle="--")
        right.set_ylim(0.0, 100.0)
        right.legend(loc="upper left", fontsize=8)
        label(right, "gap closed, of what the oracle closes (%)", "cases (%)")


def _before_and_after(axes: Axes, errors: Sequence[Errors]) -> None:
    series = (
        ("nominal", [e.nominal / e.noise for e in errors], "#b5bfca"),
        ("refitted", [e.refit / e.noise for e in errors], SIMULATED),
        ("with the diagnosis", [e.after[DIAGNOSIS] / e.noise for e in errors], MEASURED),
        ("oracle", [e.oracle / e.noise for e in errors], "#222222"),
    )
    for name, values, colour in series:
        share = 100.0 * (np.arange(len(values)) + 1.0) / max(1, len(values))
        axes.step(np.sort(values), share, where="post", color=colour, lw=1.3, label=name)
    if errors:
        axes.set_xscale("log")
    axes.set_ylim(0.0, 100.0)
    axes.legend(loc="lower right", fontsize=8)
    label(axes, "held-out error over the noise", "cases (%) below")


def _closed(axes: Axes, method: Method, errors: Sequence[Errors], colour: str) -> None:
    values = [max(e.closed[method.name], WORST) for e in errors if method.name in e.closed]
    share = 100.0 * (np.arange(len(values)) + 1.0) / max(1, len(values))
    axes.step(100.0 * np.sort(values), share, where="post", color=colour, lw=1.3, label=method.name)
