"""Friction against Coulomb's law, its stiffness when stuck, Stribeck's curve and an integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.mechanics.friction import law
from microgripper_control.effects.registry import registry
from microgripper_control.effects.slipping_springs import SPRINGS
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant, simulate

LINK = "friction"
COULOMB = 10.0  # N
triangle = 80.0 - 80.0 * np.abs(1.0 - np.arange(4001) / 1000.0 % 2.0)  # V, from 0 V, two cycles


def straight(model: Model, voltage: Array, period: float = 1e-3) -> tuple[Array, Array]:
    """Free displacement and position of a linear rig whose voltage runs straight, m."""
    linear = model.with_values({("bouc_wen", "alpha"): 0.0})
    w = linear.value("bouc_wen", "d") * voltage
    return w, simulate(linear, voltage, period, hold=Hold.FIRST)


def test_sliding_it_lags_by_coulombs_force(paper: Model) -> None:
    s = paper.values("second_order")
    w, x = straight(paper.with_link(LINK, coulomb=COULOMB, stiffness=1e9, excess=0.0), triangle)
    rising, falling = slice(2200, 3000), slice(3200, 4000)
    for part, sign in ((rising, 1.0), (falling, -1.0)):
        pull = s["k"] * w[part] - (s["k"] + s["k_s"]) * x[part]
        speed = np.gradient(x[part], 1e-3)
        np.testing.assert_allclose(pull - s["b"] * speed, sign * COULOMB, rtol=1e-6)


def test_stuck_it_is_a_spring(paper: Model) -> None:
    s, stiffness = paper.values("second_order"), 3e7
    swing = 80.0 + 0.05 * np.sin(np.arange(2000) / 50.0)
    voltage = np.append(np.linspace(0.0, 80.0, 1000), swing)
    # After it came to rest on the way up, small swings move it back and forth along that spring.
    w, x = straight(paper.with_link(LINK, coulomb=1e6, stiffness=stiffness, excess=0.0), voltage)
    expected = s["k"] / (s["k"] + s["k_s"] + stiffness)
    gain = np.ptp(x[-1000:]) / np.ptp(w[-1000:])
    assert gain == pytest.approx(expected, rel=0.02)


def test_the_force_falls_with_speed_as_stribeck_says(paper: Model) -> None:
    s, d = paper.values("second_order"), paper.value("bouc_wen", "d")
    excess, scale = 0.6, 2e-5
    model = paper.with_link(
        LINK, coulomb=COULOMB, stiffness=1e8, excess=excess, stribeck_speed=scale
    )
    for speed in (0.1 * scale, scale, 5.0 * scale):
        rate = speed / d * (s["k"] + s["k_s"]) / s["k"]
        voltage = np.linspace(0.0, 60.0, int(60.0 / rate / 1e-3))
        w, x = straight(model, voltage)
        pull = s["k"] * w[-10:] - (s["k"] + s["k_s"]) * x[-10:] - s["b"] * speed
        expected = COULOMB * (1.0 + excess / (1.0 + (speed / scale) ** 2))
        np.testing.assert_allclose(pull, expected, rtol=1e-3)


def test_a_soft_drive_sticks_and_slips(slow: Model) -> None:
    """Breaking away takes more force than sliding, so a slow pull goes in jerks."""
    k = slow.value("second_order", "k")
    values = {"coulomb": 3e-7 * k, "stiffness": 20.0 * k, "stribeck_speed": 2e-4}
    voltage = np.linspace(0.0, 140.0, 4000)  # about half the Stribeck speed
    jerks = []
    for excess in (0.0, 1.0):
        _, x = straight(slow.with_link(LINK, **values, excess=excess), voltage, 5e-5)
        steps = np.diff(x[2000:])
        jerks.append(np.max(steps) / np.mean(steps))
    assert jerks[0] < 1.1
    assert jerks[1] > 2.5


def test_a_faster_way_is_the_same_way(paper: Model) -> None:
    """Without excess it knows the path, not the time."""
    model = paper.with_link(LINK, excess=0.0)
    _, quick = straight(model, triangle, 1e-2)
    _, slow = straight(model, triangle, 1.0)
    np.testing.assert_allclose(quick, slow, rtol=0.0, atol=1e-6 * np.ptp(slow))


@pytest.mark.parametrize(
    ("rig", "stiffness", "excess", "shape", "damped", "tolerance"),
    [
        ("paper", 0.4, 0.0, (0.0, 1.0), 0.0, (0.02, 0.02, 0.01, 0.1)),
        ("paper", 2.0, 0.5, (0.0, 1.0), 0.0, (0.02, 0.04, 0.02, 0.1)),
        ("slow", 0.4, 0.0, (0.0, 1.0), 0.0, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 2.0, 0.5, (0.0, 1.0), 0.0, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 2.0, 0.0, (3.0, 0.0), 0.0, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 2.0, 0.5, (1.0, 0.4), 0.0, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 0.4, 0.0, (0.0, 1.0), 0.3, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 0.4, 0.0, (0.0, 1.0), 3.0, (1e-3, 1e-3, 1e-3, 1e-3)),
        ("slow", 2.0, 0.5, (1.0, 0.4), 0.3, (0.01, 0.02, 0.02, 0.01)),
        ("slow", 2.0, 0.0, (3.0, 0.0), 1.0, (3e-3, 3e-3, 1e-3, 1e-3)),
        ("paper", 0.4, 0.0, (0.0, 1.0), 0.3, (0.01, 0.01, 0.01, 0.1)),
        ("paper", 0.4, 0.0, (0.0, 1.0), 3.0, (0.01, 0.01, 0.02, 0.1)),
        ("paper", 2.0, 0.0, (0.0, 1.0), 1.0, (0.01, 0.01, 0.02, 0.1)),
    ],
)
def test_it_meets_an_integrator(
    rig: str,
    stiffness: float,
    excess: float,
    shape: tuple[float, float],
    damped: float,
    tolerance: tuple[float, ...],
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    s, scale = model.values("second_order"), 1e-2
    k = s["k"]
    values = {"coulomb": 2e-7 * k, "stiffness": stiffness * k}
    values["damping"] = damped * np.sqrt(values["stiffness"] * s["m"])
    bend, recovery = shape
    values |= {"excess": excess, "stribeck_speed": scale, "bend": bend, "recovery": recovery}

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        (f,) = own
        r = np.sign(v) * f / (values["coulomb"] * (1.0 + excess / (1.0 + (v / scale) ** 2)))
        share = 1.0 - recovery * r if r < 0.0 else (1.0 - r) * (1.0 + bend * r)
        return -f - values["damping"] * v * share, [values["stiffness"] * v * share]

    errors = agreement(model, LINK, values, force, 1)
    assert np.all(np.array(errors) < tolerance), errors


def test_a_damping_that_cannot_be_followed_is_refused(paper: Model) -> None:
    """It would be told as a motion of millimetres; a fit that comes by must not end there."""
    stuck = paper.with_link(LINK, coulomb=COULOMB, stiffness=2e7, damping=1e5)
    assert np.all(np.isnan(simulate(stuck, triangle, 1e-4)))
    with pytest.raises(MicrogripperError, match=r"damps by 100000 N\*s/m; .* up to 5\d{3} can"):
        Plant(stuck, 1e-4)


def test_a_bent_bristle_comes_back_as_stiff_as_it_went(paper: Model) -> None:
    """Without recovery the way back from slipping is straight, at the bristle's own stiffness."""
    s, stiffness = paper.values("second_order"), 3e7
    back = np.linspace(100.0, 90.0, 200)
    voltage = np.concatenate([np.linspace(0.0, 100.0, 2000), back])
    values = {"coulomb": COULOMB, "stiffness": stiffness, "excess": 0.0, "recovery": 0.0}
    w, x = straight(paper.with_link(LINK, **values, bend=2.0), voltage, 1e-2)
    # The spring lets go of its force over coulomb / stiffness; half of that is looked at.
    held = x[-200:] > x[-200] - 0.5 * COULOMB / stiffness
    gain = np.polyfit(w[-200:][held], x[-200:][held], 1)[0]
    assert gain == pytest.approx(s["k"] / (s["k"] + s["k_s"] + stiffness), rel=0.01)


@pytest.mark.parametrize(("decades", "taper"), [(0.0, 0.0), (0.3, 2.0), (1.5, -1.0), (2.0, 0.5)])
def test_slipping_bit_by_bit_it_ends_at_coulombs_force(
    paper: Model, decades: float, taper: float
) -> None:
    """It begins at the whole stiffness and slides, when all has slipped, against `coulomb`."""
    stiffness = 3e7
    values = {"coulomb": COULOMB, "stiffness": stiffness, "distributed": 1.0}
    values |= {"decades": decades, "taper": taper}
    given = registry()[LINK].force
    assert given is not None
    c = np.array(given.coefficients(paper.with_link(LINK, **values).values(LINK)))
    limits = c[8 : 8 + SPRINGS]
    first, whole = limits.min(), limits.max()
    before, after = np.zeros(1 + SPRINGS), np.zeros(1 + SPRINGS)
    assert law(c, before, after, 0.0, 0.5 * first, 1.0, 1.0) == pytest.approx(
        -0.5 * first * stiffness
    )
    assert law(c, before, after, 0.0, 1.01 * whole, 1.0, 1.0) == pytest.approx(-COULOMB)
    assert law(c, after, after, 0.0, -2.01 * whole, -1.0, 1.0) == pytest.approx(COULOMB)


def test_slipping_bit_by_bit_it_meets_an_integrator(
    slow: Model, agreement: Callable[..., list[float]]
) -> None:
    k = slow.value("second_order", "k")
    values = {"coulomb": 2e-7 * k, "stiffness": 0.4 * k, "distributed": 1.0}
    values |= {"decades": 0.7, "taper": 0.0}
    # Springs as stiff as each other that slide against `coulomb` together.
    shares = np.geomspace(1.0, 10.0**-0.7, SPRINGS)
    limits = values["coulomb"] * shares / np.sum(shares)

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        slips = (np.abs(own) >= limits) & (own * v > 0.0)
        rates = np.where(slips, 0.0, values["stiffness"] / SPRINGS * v)
        return -float(np.sum(own)), rates.tolist()

    assert max(agreement(slow, LINK, values, force, SPRINGS)) < 2e-3


def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    """Held steps ring, and ringing shakes the friction off; 50 N are left to see."""
    truth = np.array([50.0, 2e7])
    rig = paper.with_link(LINK, coulomb=truth[0], stiffness=truth[1], excess=0.0)
    found, errors = recover(rig, LINK, {"coulomb": 30.0, "stiffness": 1e7}, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.2 * truth)


def test_a_planted_damping_is_found(
    slow: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    """A rig that rings from sample to sample shows what the bristle takes from the ringing."""
    truth = np.array([0.3, 1e5, 1.0])
    values = dict(zip(("coulomb", "stiffness", "damping"), truth, strict=True))
    start = {"coulomb": 0.2, "stiffness": 1.5e5, "damping": 2.0}
    shape = {"excess": 0.0, "bend": 2.0, "recovery": 0.1}
    found, errors = recover(slow.with_link(LINK, **values, **shape), LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.1 * truth)


@pytest.mark.parametrize(("rig", "period", "seen"), [("paper", 1e-3, 0), ("slow", 1e-3, 6)])
def test_damping_is_asked_where_ringing_lasts(
    rig: str, period: float, seen: int, request: pytest.FixtureRequest
) -> None:
    model: Model = request.getfixturevalue(rig)
    s = model.values("second_order")
    scales = Scales(period, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), s["k"] + s["k_s"], s["m"])
    link = registry()[LINK]
    given = [model.with_link(LINK, **start).values(LINK) for start in link.starts(scales)]
    assert sum("damping" not in link.idle(values) for values in given) == seen
