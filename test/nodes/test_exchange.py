"""What the control law is told of its plant, on a way out that leads nowhere."""

from __future__ import annotations

from typing import Any, cast

import pytest

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.pid import PidGains
from microgripper_control.nodes.applied_watch import AppliedWatch
from microgripper_control.nodes.controller_settings import load_identified
from microgripper_control.nodes.exchange import Exchange
from microgripper_control.nodes.feedback_watch import FeedbackWatch
from microgripper_control.nodes.pairing import Paired

T = 1e-3


class Nowhere:
    """Takes voltages as `VoltageOutput` does."""

    elapsed = 1.0  # s: no rate is too high

    def send(self, guard: object) -> float:
        return 0.0


def test_samples_that_were_lost_do_not_make_the_plant_seem_faster(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gains = PidGains(kp=0.0, ki=0.0, kd=2e3, derivative_filter=0.0)
    controller = Controller(load_identified("apa120s.yaml"), T, gains=gains, mode=Mode.PID)
    exchange = Exchange(
        controller,
        cast(Any, Nowhere()),
        FeedbackWatch(0.06, T),
        AppliedWatch(10.0, 1e3),
        sample_period=T,
        lockstep=False,
    )
    derivatives = []
    for tick in (0, 1, 2, 3, 8, 9, 20, 21):
        now = 100.0 + tick * T
        monkeypatch.setattr("time.monotonic", lambda now=now: now)
        assert exchange.meets(tick * 1_000_000, 1e-7 * tick, 0.0, now)
        exchange.answer(Paired(1e-7 * tick, 0.0, 5e-6), returns=False)
        derivatives.append(controller._pid._derivative)
    assert derivatives[1:] == pytest.approx(7 * [-0.2])
