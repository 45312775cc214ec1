"""What h tells of the time before a run, against loops that have settled."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import GONE, HYSTERESIS, LEVELS, Timing
from microgripper_control.effects.material.bouc_wen import LINK, advance
from microgripper_control.effects.past import gone_since_turn

D, ALPHA = 1.4e-7, 0.08
LOOPS = 60


def settled(beta: float, gamma: float, span: float, up: bool) -> float:
    """h, m, at an end of a loop over `span` volts that has been gone through often."""
    h = 0.0
    for _ in range(LOOPS):
        for change in (-span, span) if up else (span, -span):
            h = advance(h, change, ALPHA * D, beta, gamma, 1.0)
    return h


def gone(h: float, **changed: float) -> float:
    levels = np.zeros(LEVELS)
    levels[HYSTERESIS] = h
    values = {"d": D, "alpha": ALPHA, "beta": 0.0, "gamma": 0.0, "n": 1.0, **changed}
    LINK.prepare(values, Timing(1e-3, (1e-3,), ramped=False), levels)
    return float(levels[GONE])


@pytest.mark.parametrize(("beta", "gamma"), [(0.015, -0.022), (0.01, 0.0), (0.02, -0.02)])
@pytest.mark.parametrize("span", [20.0, 150.0])
@pytest.mark.parametrize("up", [False, True])
def test_a_settled_loop_is_as_long_as_h_says(
    beta: float, gamma: float, span: float, up: bool
) -> None:
    found = gone(settled(beta, gamma, span, up), beta=beta, gamma=gamma)
    assert found == pytest.approx(D * span if up else -D * span, rel=1e-6)


def test_what_h_cannot_tell_stays_finite() -> None:
    assert gone(0.0, beta=0.015) == 0.0
    assert gone(1e-6, alpha=0.0) == 0.0
    assert 0.0 < gone(1e-3, beta=0.015) < np.inf  # far beyond where it saturates


def test_nothing_forgotten_is_two_ways_to_h() -> None:
    assert gone_since_turn(-1e-7, 0.1, (0.0, 0.0)) == pytest.approx(-2e-6)
