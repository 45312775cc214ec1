from __future__ import annotations

import math
import re

import numpy as np
import pytest

from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.live_comparison import LiveComparison
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

pytestmark = pytest.mark.ros

RATE = 200.0
TIME = np.arange(2000) / RATE
VOLTAGE = 80.0 - 70.0 * np.cos(4.0 * np.pi * TIME)
NOISE = np.random.default_rng(2).normal(0.0, 15e-9, len(TIME))
RIGHT = simulate(nominal_model(), VOLTAGE, 1.0 / RATE) + NOISE
LATE = simulate(nominal_model().with_link("transport_delay", delay=0.01), VOLTAGE, 1.0 / RATE)


class Bench:
    """A comparison and its clock."""

    def __init__(self) -> None:
        self.now = 100.0
        self.it = LiveComparison(nominal_model(), RATE, gap_window=1.0, kept=5.0, now=self.now)

    def run(self, displacement: np.ndarray, *, every: float = 1.0 / RATE) -> Health:
        """The health after a run; the samples come at the times of their stamps."""
        for voltage, position in zip(VOLTAGE, displacement, strict=True):
            self.now += every
            self.it.take(round(1e9 * self.now), voltage, position, self.now)
        self.it.read(3.0, 1e-9, self.now)
        return self.it.health(self.now)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_model_that_holds_and_one_that_does_not(bench: Bench) -> None:
    right = bench.run(RIGHT)
    assert right.level is Level.OK
    expected = "the model holds: gap 1[3-6] nm, noise floor 1[2-7] nm, 1.[01] times"
    assert re.fullmatch(expected, right.message)
    wrong = bench.run(LATE + NOISE)
    assert wrong.level is Level.WARN
    assert wrong.message.startswith("the model no longer holds: gap ")
    assert wrong.values["gap in noise floors"] > 3.0  # type: ignore[operator]
    # The numbers change from report to report; that is no news.
    assert wrong.news == bench.run(LATE + 1.1 * NOISE).news != right.news


def test_another_model_begins_anew(bench: Bench) -> None:
    bench.run(LATE + NOISE)
    bench.it.use(nominal_model().with_link("transport_delay", delay=0.01))
    assert bench.it.health(bench.now).message.startswith("warming up")
    assert bench.run(LATE + NOISE).level is Level.OK


def test_without_samples_it_is_stale(bench: Bench) -> None:
    assert bench.it.health(bench.now).message == "waiting for joint_states"
    assert bench.it.health(bench.now).level is Level.STALE
    bench.run(RIGHT)
    health = bench.it.health(bench.now + 3.0)
    assert (health.level, health.message) == (Level.STALE, "no joint_states for 3 s")
    assert bench.it.read(3.0, 1e-9, bench.now + 3.0) is None
    # After a pause it is another run, of which nothing is known.
    bench.now += 10.0
    assert bench.run(RIGHT).level is Level.OK
    assert bench.it.health(bench.now).values["new beginnings"] == 1


def test_another_rate_is_a_warning(bench: Bench) -> None:
    health = bench.run(RIGHT, every=2.0 / RATE)
    assert health.level is Level.WARN
    assert health.message == "joint_states come at 100 Hz, not at sample_rate, 200 Hz"


def test_what_is_no_number_is_a_warning_once(bench: Bench) -> None:
    bench.run(RIGHT)
    for voltage, position in ((math.nan, 0.0), (0.0, math.inf)):
        bench.it.take(0, voltage, position, bench.now)
    health = bench.it.health(bench.now)
    assert health.level is Level.WARN
    assert health.message == "joint_states without a finite position and effort"
    assert health.values["samples unusable"] == 2
    assert bench.it.health(bench.now).level is Level.OK
