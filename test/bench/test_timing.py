"""Contestants take turns, and ratios come from the rounds."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest

from microgripper_control.bench.growth import exponent
from microgripper_control.bench.loops import Trips
from microgripper_control.bench.timing import Contestant, Spread, Times, take_turns
from microgripper_control.core.errors import MicrogripperError


def test_contestants_take_turns() -> None:
    calls: list[str] = []
    contestants = {name: Contestant(lambda name=name: calls.append(name)) for name in "ab"}
    times = take_turns(contestants, rounds=3)
    assert {name: len(rounds) for name, rounds in times.rounds.items()} == {"a": 3, "b": 3}
    turns = "".join(name for name, _ in groupby(calls))
    assert turns == "ab" + 3 * "ab"  # warming up, then the rounds


def test_times_are_for_a_unit_of_work(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0

    def tick() -> float:
        return now

    def work() -> None:
        nonlocal now
        now += 0.5

    monkeypatch.setattr("microgripper_control.bench.timing.time.perf_counter", tick)
    times = take_turns({"a": Contestant(work, 100.0), "b": Contestant(work, 50.0)}, rounds=2)
    assert times.of("a").median == pytest.approx(0.005)
    assert times.ratio("b", "a") == pytest.approx((2.0, 2.0, 2.0))


def test_a_ratio_is_that_of_the_rounds_not_of_the_medians() -> None:
    times = Times({"slow": np.array([2.0, 20.0, 6.0]), "fast": np.array([1.0, 10.0, 3.0])})
    assert times.ratio("slow", "fast") == Spread(2.0, 2.0, 2.0)


@pytest.mark.parametrize("power", [0.0, 1.0, 2.0])
def test_the_exponent_of_a_power_law(power: float) -> None:
    sizes = (1.0, 3.0, 10.0)
    costs = np.array([[5.0 * size**power] * 4 for size in sizes])
    assert exponent(sizes, costs) == pytest.approx((power, power, power))


SENT = 1e-3 * np.arange(4000)  # s
COUNTED = 3000 - 2  # ticks: neither the one at the end of settling nor the last


def test_round_trips_and_misses() -> None:
    sent = np.delete(SENT, [2000, 2001])
    found = Trips.of(sent, sent + 3e-4, 1e-3)
    np.testing.assert_allclose(found.round_trips, 3e-4, rtol=1e-6)
    assert found.unsent == pytest.approx(2.0 / COUNTED, rel=0.01)
    assert found.missed == found.unsent


def test_a_late_answer_is_a_long_round_trip() -> None:
    answered = np.delete(SENT + 3e-4, 2000)
    found = Trips.of(SENT, answered, 1e-3)
    assert np.max(found.round_trips) == pytest.approx(1.3e-3)
    assert found.missed == pytest.approx(1.0 / COUNTED, rel=0.01)


def test_samples_that_are_hardly_ever_answered_are_missed() -> None:
    sent = 2.5e-4 * np.arange(16_000)
    found = Trips.of(sent, sent[::40] + 1e-3, 2.5e-4)
    assert found.unsent == 0.0
    assert found.missed == pytest.approx(39.0 / 40.0, abs=1e-3)


def test_a_controller_that_dies_misses_the_rest() -> None:
    found = Trips.of(SENT, SENT[:2000] + 3e-4, 1e-3)
    assert found.missed == pytest.approx(2.0 / 3.0, abs=1e-3)
    assert np.median(found.round_trips) == pytest.approx(0.5, abs=0.01)


def test_answers_that_all_come_after_the_next_sample_are_late() -> None:
    answered = SENT + 1.2e-3
    assert Trips.of(SENT, answered, 1e-3).missed == 0.0  # they might be quick ones to the next
    found = Trips.of(SENT, answered, 1e-3, soonest=4e-4)
    assert found.missed == 1.0
    assert np.median(found.round_trips) == pytest.approx(1.2e-3)


def test_samples_before_the_partners_have_met_do_not_count() -> None:
    answered = SENT[1000:] + 3e-4
    assert Trips.of(SENT, answered, 1e-3).missed == 0.0


def test_samples_without_an_answer_are_an_error() -> None:
    with pytest.raises(MicrogripperError, match="not answered"):
        Trips.of(np.arange(10.0), np.zeros(0), 1.0)
