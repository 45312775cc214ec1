"""The row of the loop: what its lines compare, and the highest rate that it finds."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.bench.highest_rate import highest_rate
from microgripper_control.bench.loops import OURS, Trips
from microgripper_control.bench.numbers import figure
from microgripper_control.bench.row import Effort, Line, Measured
from microgripper_control.bench.rows import loop

PRIORITY = "real-time priority"


def trips(slow: float = 1.0, missed: float = 0.0) -> Trips:
    """A run of 1000 ticks, `slow` times as long and as uneven as another one."""
    off = np.linspace(-1e-5, 1e-5, 1000)
    return Trips(slow * np.full(1000, 4e-4), 1e-3 + slow * off, missed, 0.0)


@pytest.fixture
def measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Callable[[Callable[[float], float]], Measured]:
    """Measures with runs of ours that miss at a rate, Hz, the share that a function says."""

    def measure(missed: Callable[[float], float]) -> Measured:
        def run_loop(
            folder: Path, pair: tuple[str, str], duration: float, rate: float, *given: object
        ) -> Trips:
            return trips(1.25, missed(rate)) if pair == OURS else trips()

        monkeypatch.setattr(loop, "run_loop", run_loop)
        return loop.measure(Effort(tmp_path))

    monkeypatch.setattr(loop, "refusal", lambda priority: None)
    return measure


def named(found: Measured, what: str) -> Line:
    return next(line for line in found.lines if line.what.startswith(what))


def test_ours_takes_so_many_times_as_long(measured: Callable[..., Measured]) -> None:
    found = measured(lambda rate: 2e-4)
    for what in ("round trip, median", "round trip, 99th percentile", "jitter"):
        assert named(found, what).figure == pytest.approx((1.25, 1.25, 1.25))
    assert named(found, "ticks missed").figure.median == pytest.approx(0.02)


@pytest.mark.parametrize("highest", loop.RATES)
def test_the_highest_rate_is_found(measured: Callable[..., Measured], highest: float) -> None:
    line = named(measured(lambda rate: 0.0 if rate <= highest else 0.5), "highest rate")
    assert line.figure.median == highest
    tried = [float(rate) for rate in re.findall(r"\d+", line.against)]
    assert tried == sorted(tried)
    assert highest in tried
    assert len(tried) == 4


def test_one_bad_run_does_not_decide(measured: Callable[..., Measured]) -> None:
    each_third = cycle((0.0, 0.5, 0.0))
    found = measured(lambda rate: next(each_third) if rate == 4000.0 else float(rate > 4000.0))
    assert named(found, "highest rate").figure.median == 4000.0


def test_where_the_usual_rate_is_missed_the_highest_is_below_it(
    measured: Callable[..., Measured],
) -> None:
    found = measured(lambda rate: 0.045)
    line = named(found, "highest rate")
    assert figure(line) == "below 1 000 Hz"
    assert line.against == "tried 1000 Hz"
    assert named(found, "ticks missed").outcome == "missed"


def test_rates_above_one_that_fails_are_not_tried() -> None:
    tried = []

    def kept(rate: float) -> bool:
        tried.append(rate)
        return rate < 3.0

    found = highest_rate((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), kept)
    assert found.rate == 2.0
    assert tried == [1.0, 4.0, 2.0, 3.0]
    assert found.tried == (1.0, 2.0, 3.0, 4.0)


def test_what_is_not_permitted_is_not_told_as_measured(
    measured: Callable[..., Measured], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loop, "refusal", lambda priority: "Operation not permitted; see the limit")
    found = measured(lambda rate: 0.0)
    assert found.lines
    assert not any(PRIORITY in line.what for line in found.lines)
    assert "not measured: Operation not permitted; see the limit." in found.notes[-1]
