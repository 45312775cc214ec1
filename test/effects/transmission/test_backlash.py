"""Play against its own definition and the geometry of its loops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.signals import POSITION, Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

PLAY = 2e-6  # m
Alone = Callable[..., Array]


def played(alone: Alone, x: Array) -> Array:
    return alone("backlash", {"play": PLAY}, x, (1e-3,), row=POSITION, ramped=True)


def test_the_finger_rests_inside_the_gap_and_is_pushed_at_its_flanks(alone: Alone) -> None:
    x = 1e-6 * np.array([0.0, 0.9, -0.9, 3.0, 1.5, 1.0, 0.0, -1.0, 0.5, 1.0, 1.5])
    expected = 1e-6 * np.array([0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.5])
    np.testing.assert_allclose(played(alone, x), expected, atol=1e-20)


def test_a_cycle_is_a_parallelogram(alone: Alone) -> None:
    """As wide as the play, and as high as the motion less the play."""
    x = 10e-6 * np.sin(np.linspace(0.0, 6.0 * np.pi, 6001))
    out = played(alone, x)[2000:]
    assert np.ptp(out) == pytest.approx(20e-6 - PLAY, rel=1e-6)
    motion = x[2000:]
    down, up = (  # where the finger passes the middle on its way
        np.interp(0.0, sign * out[part], motion[part])
        for sign, part in ((-1.0, slice(500, 1500)), (1.0, slice(1500, 2500)))
    )
    assert up - down == pytest.approx(PLAY, rel=1e-3)


def test_only_the_course_counts_not_its_speed(alone: Alone) -> None:
    """Sampled ten times as densely, or held where it is now and then, x moves the finger alike."""
    x = np.random.default_rng(1).normal(scale=2e-6, size=400)
    dense = np.interp(np.arange(0, 3991) / 10.0, np.arange(400), x)
    np.testing.assert_allclose(played(alone, dense)[::10], played(alone, x), atol=1e-19)
    np.testing.assert_array_equal(played(alone, np.repeat(x, 3))[::3], played(alone, x))


@pytest.mark.parametrize("rig", ["paper", "slow"])
def test_ringing_between_the_samples_pushes_the_finger(
    rig: str,
    request: pytest.FixtureRequest,
    lively: Array,
    finely: Callable[[Model, Array, float], Array],
) -> None:
    base: Model = request.getfixturevalue(rig)
    model = base.with_link("backlash", play=2e-7)
    expected = finely(model, lively, 1e-3)
    absent = simulate(base, lively, 1e-3)
    error = np.linalg.norm(simulate(model, lively, 1e-3) - expected)
    assert error < 0.02 * np.linalg.norm(absent - expected)


def test_it_never_moves_the_finger_by_more_than_half_the_play(alone: Alone) -> None:
    x = np.random.default_rng(2).normal(scale=3e-6, size=1000).cumsum()
    assert np.max(np.abs(played(alone, x) - x)) == pytest.approx(PLAY / 2.0, rel=1e-9)


def test_a_planted_play_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    rig = paper.with_link("backlash", play=3e-7)
    found, errors = recover(rig, "backlash", {"play": 2e-7}, lively, 1e-3)
    assert abs(found[0] - 3e-7) < 4.0 * errors[0]
    assert errors[0] < 3e-9
