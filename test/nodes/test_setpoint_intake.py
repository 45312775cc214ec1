from __future__ import annotations

import math

import pytest

from microgripper_control.nodes.setpoint_intake import (
    STREAM,
    OutOfReach,
    SetpointIntake,
    StreamLoss,
)

REACH = (2e-6, 18e-6)
LIMIT = 0.2


def intake(
    out_of_reach: OutOfReach = OutOfReach.CLAMP,
    loss: StreamLoss = StreamLoss.RETURN,
    limit: float = LIMIT,
) -> SetpointIntake:
    return SetpointIntake(out_of_reach, loss, limit)


def stream(made: SetpointIntake, start: float, count: int = STREAM) -> float:
    """Send setpoints once a millisecond; when the last one came."""
    for k in range(count):
        made.take(5e-6, REACH, start + 1e-3 * k)
    return start + 1e-3 * (count - 1)


def wait(made: SetpointIntake, start: float, length: float) -> float:
    """Look every 10 ms; when that ends."""
    for k in range(1, round(length / 0.01) + 1):
        made.look(start + 0.01 * k)
    return start + length


def test_setpoints_set_by_hand_are_no_stream_that_could_stop() -> None:
    made = intake()
    now = 0.0
    for _ in range(2 * STREAM):
        made.take(5e-6, REACH, now)
        now = wait(made, now, 1.0)
        assert made.state == "by hand"
        assert not made.returns


@pytest.mark.parametrize("loss", StreamLoss)
def test_a_stream_that_stops_is_noticed_and_the_next_setpoint_ends_that(loss: StreamLoss) -> None:
    made = intake(loss=loss)
    now = stream(made, 0.0)
    assert made.state == "stream"
    assert made.left == pytest.approx(LIMIT)
    now = wait(made, now, LIMIT - 0.02)
    assert made.state == "stream"
    now = wait(made, now, 0.03)
    assert made.returns == (loss is StreamLoss.RETURN)
    assert made.state == ("stopped: returned to safe" if made.returns else "stopped: held")
    made.take(5e-6, REACH, now)
    assert not made.returns
    assert made.state == "by hand"
    stream(made, now)
    assert (made.state, made.stops) == ("stream", 1)


def test_without_a_limit_no_stream_stops() -> None:
    made = intake(limit=0.0)
    wait(made, stream(made, 0.0), 10.0)
    assert not made.stopped


def test_out_of_reach_is_passed_on_to_be_clamped_or_refused() -> None:
    clamps, refuses = intake(), intake(OutOfReach.REFUSE)
    for wild in (-1.0, 1.0):
        assert clamps.take(wild, REACH, 0.0) == wild
        assert math.isnan(refuses.take(wild, REACH, 0.0))
    assert refuses.take(5e-6, REACH, 0.0) == 5e-6
    assert (clamps.refused, refuses.refused) == (0, 2)
    assert math.isnan(refuses.take(math.nan, REACH, 0.0))
    assert refuses.refused == 2  # that one is counted as not finite


def test_what_is_refused_ends_no_stop_and_keeps_no_stream_up() -> None:
    made = intake(OutOfReach.REFUSE)
    now = wait(made, stream(made, 0.0), 2.0 * LIMIT)
    assert made.returns
    for bad in (math.nan, math.inf, 1.0):
        assert math.isnan(made.take(bad, REACH, now))
        assert made.returns
    made = intake(OutOfReach.REFUSE)
    now = stream(made, 0.0)
    for _ in range(50):
        now = wait(made, now, 0.01)
        made.take(math.nan, REACH, now)
    assert made.returns
