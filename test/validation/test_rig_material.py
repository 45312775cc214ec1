"""Effects of the material against closed forms, direct sums and the rules they are known by."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from rig_runs import PAPER, PERIOD, applied

from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import Element, Surroundings
from microgripper_control.validation.relaxations import logarithmic, power_law, rates

STEP = 1e-3


def change(effect: str, form: str, strength: float, voltage: Array, **given: float) -> Array:
    """What the effect adds to d u, m, for a held voltage on a grid of 1 ms."""
    made = applied(effect, form, strength, **given)
    around = Surroundings(PAPER.scale, PERIOD, STEP, 0.0, 60.0, np.random.SeedSequence(5))
    built = made.form.build(strength, made.shape, around)
    assert isinstance(built, Element)
    free = PAPER.base.d * voltage
    signal = free.copy()
    built.run(Block(-STEP, STEP, signal, voltage, np.zeros(len(voltage))))
    return signal - free


def swing(low: float, high: float, count: int) -> Array:
    return np.concatenate([np.linspace(low, high, count), np.linspace(high, low, count)])


def test_sums_over_rates_are_the_logarithm_and_the_power() -> None:
    t = np.geomspace(1e-3, 100.0, 30)
    grown = 1.0 - np.exp(-np.outer(t, rates()))
    assert grown @ logarithmic(0.01) == pytest.approx(np.log1p(t / 0.01), rel=2e-4)
    # Beyond the fastest rate the power law is left out, which at 1e5 / s is this much.
    left_out = 1e5**-0.2 / 1.1642297137253030
    assert grown @ power_law(0.2) == pytest.approx(t**0.2 - left_out, abs=2e-2)


def test_after_a_step_creep_is_the_logarithm_of_the_time() -> None:
    grown = change("creep", "a", 0.01, np.full(40_000, 100.0), onset=0.01)
    t = STEP * np.arange(1, 40_001)
    moved = PAPER.base.d * 100.0
    assert grown == pytest.approx(0.01 * moved * np.log1p(t / 0.01), rel=1e-3, abs=1e-13)


def test_for_any_course_creep_is_the_superposition_over_the_past() -> None:
    rng = np.random.default_rng(0)
    voltage = np.repeat(rng.uniform(0.0, 160.0, 20), 50)
    grown = change("creep", "a", 0.01, voltage, onset=0.02)
    jumps = PAPER.base.d * np.diff(voltage, prepend=0.0)
    t = STEP * np.arange(1, 1001)
    kernel = 0.01 * np.log1p(t / 0.02)
    assert grown == pytest.approx(np.convolve(jumps, kernel)[:1000], rel=1e-3, abs=1e-12)


def test_fractional_creep_grows_by_the_same_factor_in_each_decade_less_its_onset() -> None:
    grown = change("creep", "b", 0.02, np.full(30_000, 100.0), order=0.25, field=0.0)
    first, second, third = grown[[299, 2999, 29_999]]
    assert (third - second) / (second - first) == pytest.approx(10**0.25, rel=5e-3)


def test_the_rate_widens_both_loops_and_rest_does_not() -> None:
    for form, strength in (("a", 0.5), ("b", 0.3)):
        widths = []
        for count in (200, 800, 3200):
            voltage = np.tile(swing(0.0, 150.0, count), 3)
            last = (
                voltage * PAPER.base.d
                + change("rate_dependent_hysteresis", form, strength, voltage)
            )[-2 * count :]
            widths.append(abs(last[:count] - last[count:][::-1]).max())
        assert widths[0] > widths[1] > widths[2]


def test_asymmetry_has_no_rate_and_closes_its_loop() -> None:
    for form in "ab":
        fast = change("asymmetric_hysteresis", form, 0.3, np.tile(swing(0.0, 150.0, 500), 3))
        slow = change("asymmetric_hysteresis", form, 0.3, np.tile(swing(0.0, 150.0, 1000), 3))
        assert slow[::1000] == pytest.approx(fast[::500], rel=0.02, abs=2e-10)
        assert fast[-1] == pytest.approx(fast[-1001], abs=1e-12)
        middle = fast[2000:3000]
        assert abs(middle[:500] - middle[500:][::-1]).max() > 1e-8


@pytest.mark.parametrize("effect", ["prandtl_ishlinskii", "preisach"])
def test_the_foreign_hystereses_wipe_out_inner_loops(effect: str) -> None:
    form = "a" if effect == "prandtl_ishlinskii" else "b"
    plain = swing(0.0, 150.0, 400)
    detour = np.concatenate([plain[:200], swing(plain[199], 40.0, 100), plain[200:]])
    assert change(effect, form, 1.0, detour)[-600:] == pytest.approx(
        change(effect, form, 1.0, plain)[-600:], abs=1e-15
    )


def test_preisach_relays_have_the_everett_integral_and_congruent_minor_loops() -> None:
    def output(turns: list[float]) -> Array:
        course = [np.linspace(a, b, 201)[1:] for a, b in pairwise(turns)]
        voltage = np.concatenate(course)
        given = {"width": 0.2, "slope": 1.0}
        added = change("preisach", "b", 1.0, voltage, **given) + PAPER.base.d * voltage
        return (added / PAPER.base.d - 0.85 * voltage) / (0.15 * 160.0)

    def g(u: float) -> float:
        return 1.0 / (1.0 + np.exp(-(u - 80.0) / 32.0))

    found = output([0.0, 150.0, 20.0, 90.0, 20.0])
    turned = found[199] - found[399]
    assert turned == pytest.approx((g(150.0) - g(20.0)) ** 2, rel=1e-9)
    small = output([0.0, 60.0, 20.0, 60.0, 20.0])
    minor, other = found[399:] - found[399], small[399:] - small[399]
    assert minor[200] == pytest.approx((g(90.0) - g(20.0)) ** 2, rel=1e-9)
    assert other[200] == pytest.approx((g(60.0) - g(20.0)) ** 2, rel=1e-9)


def test_ageing_is_the_logarithm_of_the_time() -> None:
    lost = change("ageing", "a", 0.1, np.full(60_000, 100.0), early=3.0)
    t = np.maximum(STEP * np.arange(60_000), 0.0)
    expected = -0.1 * np.log1p(t / 3.0) / np.log1p(20.0) * PAPER.base.d * 100.0
    assert lost == pytest.approx(expected, abs=1e-13)
