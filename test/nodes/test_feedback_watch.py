"""What feedback can be used, on clocks made by hand."""

from __future__ import annotations

import pytest

from microgripper_control.nodes.feedback_watch import FeedbackWatch, Verdict
from microgripper_control.nodes.new_time import AGREE
from microgripper_control.nodes.silence import Silence

T = 1e-3
LIMIT = 0.06
ORIGIN = 5_000_000_000  # ns; the stamps' clock need not be this process's


class Feed:
    """A plant that sends a sample each period, with what a test does to it."""

    def __init__(self) -> None:
        self.watch = FeedbackWatch(LIMIT, T)
        self.now = 100.0

    def pass_time(self, length: float) -> bool:
        """Look every 10 ms, as a node does; whether feedback is lost in the end."""
        end = self.now + length
        while self.now < end:
            self.now = min(self.now + 0.01, end)
            self.watch.is_lost(self.now)
        return self.watch.lost

    def send(self, *, shift: float = 0.0, late: float = 0.0, finite: bool = True) -> Verdict:
        """A sample, with a stamp `shift` s off, that took `late` s longer to come."""
        self.now += T
        stamp = ORIGIN + round((self.now - late - 100.0 + shift) * 1e9)
        verdict = self.watch.take(stamp, finite, self.now)
        self.watch.is_lost(self.now)
        return verdict

    def run(self, count: int, **how: float) -> set[Verdict]:
        return {self.send(**how) for _ in range(count)}


@pytest.fixture
def feed() -> Feed:
    feed = Feed()
    assert feed.run(100) == {Verdict.FRESH}
    assert feed.watch.state == "ok"
    return feed


def test_after_a_long_pause_the_fastest_way_is_found_anew(feed: Feed) -> None:
    """One clock may have drifted; nobody set it, so that is no jump."""
    feed.pass_time(2.0)
    assert feed.run(20, late=2.0 * LIMIT) == {Verdict.LATE}
    feed.run(1)
    feed.pass_time(3600.0)
    verdicts = [feed.send(late=2.0 * LIMIT) for _ in range(20)]
    assert verdicts == [*[Verdict.OUT_OF_TIME] * (AGREE - 1), *[Verdict.FRESH] * (21 - AGREE)]
    assert feed.watch.jumps == 0
    assert feed.watch.missed == 0


def test_silence_is_a_loss_in_time_and_a_fresh_sample_ends_it(feed: Feed) -> None:
    assert not feed.pass_time(LIMIT - 0.01)
    assert feed.watch.left == pytest.approx(0.01)
    assert feed.pass_time(0.011)
    assert feed.watch.state == "lost: none comes"
    assert feed.send() is Verdict.FRESH
    assert feed.watch.resumes
    assert feed.watch.state == "ok"
    assert feed.send() is Verdict.FRESH
    assert not feed.watch.resumes
    assert feed.watch.losses == 1


def test_a_gap_that_this_process_slept_through_is_no_loss_but_a_new_beginning(feed: Feed) -> None:
    feed.now += 3.0
    assert not feed.watch.is_lost(feed.now)
    feed.send()
    assert feed.watch.resumes
    assert feed.watch.losses == feed.watch.missed == 0


def test_a_stale_sample_repeated_is_not_taken_and_becomes_a_loss(feed: Feed) -> None:
    stamp = feed.watch._stamp
    for _ in range(70):
        feed.now += T
        assert feed.watch.take(stamp, True, feed.now) is Verdict.REPEATED
        feed.watch.is_lost(feed.now)
    assert feed.watch.state == "lost: a stale sample repeated"
    assert feed.send() is Verdict.FRESH


def test_samples_without_a_finite_value_become_a_loss(feed: Feed) -> None:
    assert feed.run(70, finite=False) == {Verdict.UNUSABLE}
    assert feed.watch.state == f"lost: {Verdict.UNUSABLE.value}"


def test_samples_that_are_too_old_are_not_taken_and_no_length_of_time_makes_them_good(
    feed: Feed,
) -> None:
    feed.now += 0.05
    assert feed.run(10, late=0.05) == {Verdict.FRESH}
    feed.now += 0.45
    assert feed.run(3000, late=0.5) == {Verdict.LATE}
    assert feed.watch.state == "lost: samples too old"
    assert feed.send() is Verdict.FRESH


@pytest.mark.parametrize("shift", [3600.0, -3600.0, 0.5, -0.5])
def test_one_stamp_from_another_time_is_not_believed_and_several_are(
    feed: Feed, shift: float
) -> None:
    assert feed.send(shift=shift) is Verdict.OUT_OF_TIME
    assert feed.run(10) == {Verdict.FRESH}
    assert feed.watch.jumps == 0
    verdicts = [feed.send(shift=shift) for _ in range(20)]
    assert verdicts == [Verdict.OUT_OF_TIME] * (AGREE - 1) + [Verdict.FRESH] * (21 - AGREE)
    assert feed.watch.jumps == 1
    assert feed.watch.losses == 0


def test_wild_stamps_among_good_ones_change_nothing(feed: Feed) -> None:
    for k in range(200):
        assert feed.send() is Verdict.FRESH
        wild = (-1) ** k * (1e3 + 7.7 * k)
        feed.now -= T
        assert feed.send(shift=wild) is Verdict.OUT_OF_TIME
    assert feed.watch.jumps == feed.watch.losses == 0


def test_an_overtaken_sample_is_not_taken(feed: Feed) -> None:
    assert feed.send(shift=-5 * T) is Verdict.OUT_OF_TIME
    assert feed.send() is Verdict.FRESH


def test_ticks_without_a_sample_are_counted(feed: Feed) -> None:
    feed.now += 7 * T
    feed.send()
    assert feed.watch.missed == 7


def test_the_clocks_may_drift_apart(feed: Feed) -> None:
    for _ in range(30_000):
        feed.now += T * (1 + 2e-4)
        stamp = feed.watch._stamp + 1_000_000
        assert feed.watch.take(stamp, True, feed.now) is Verdict.FRESH


def test_a_silence_without_limit_is_never_over() -> None:
    silence = Silence(0.0)
    silence.heard(0.0)
    assert not any(silence.is_over(float(k)) for k in range(1000))


def test_a_silence_does_not_begin_before_something_was_heard() -> None:
    assert not Silence(1e-3).is_over(1e9)
