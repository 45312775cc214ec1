"""Asymmetric hysteresis: its own formula, its independence of rate, and other people's formulas."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import least_squares

from microgripper_control.core.signals import FALLEN, HIGH, LEVELS, RISEN, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Scales
from microgripper_control.effects.material.asymmetric_hysteresis import apart
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

LINK = "asymmetric_hysteresis"
VALUES = {
    "tilt": 2e-9,
    "bulge": -1.5e-11,
    "twist": 8e-14,
    "skew": 1e-7,
    "reach": 12.0,
    "delta": 0.0,
    "beta": 0.0152,
    "gamma": -0.0227,
}
NOMINAL = {p.name: p.nominal for p in link_named(LINK).parameters}
STROKE = 20e-6  # m


def test_on_a_long_rise_it_is_its_polynomial(paper: Model) -> None:
    """From rest s = 1 - exp(-u / reach), and after a turn at the top it goes to -1 likewise."""
    rise, fall = np.arange(0.0, 121.0, 2.0), np.arange(120.0, -1.0, -2.0)
    voltage = np.append(rise, fall)
    gain = 5e7 / (5e7 + 8.2e5)
    plain = simulate(paper, voltage, 0.1, hold=Hold.FIRST)
    x = simulate(paper.with_link(LINK, **VALUES), voltage, 0.1, hold=Hold.FIRST)
    up = 1.0 - np.exp(-rise / VALUES["reach"])
    down = (up[-1] + 1.0) * np.exp(-(120.0 - fall) / VALUES["reach"]) - 1.0
    s, u = np.append(up, down), voltage
    weight = VALUES["tilt"] * u + VALUES["bulge"] * u**2 + VALUES["twist"] * u**3
    expected = -gain * (weight + VALUES["skew"] * s) * s
    np.testing.assert_allclose(x - plain, expected, rtol=0.0, atol=2e-4 * np.ptp(expected))


def test_it_knows_the_way_not_the_speed(paper: Model) -> None:
    u = 80.0 - 80.0 * np.cos(np.arange(500) / 40.0)
    model = paper.with_link(LINK, **VALUES)
    quick, slow = (simulate(model, u, period, hold=Hold.FIRST) for period in (1e-2, 1.0))
    np.testing.assert_allclose(quick, slow, rtol=0.0, atol=1e-5 * np.ptp(slow))


def test_a_bipolar_loop_loses_its_symmetry(paper: Model) -> None:
    """The paper's loop under +-U is its own image in the centre, whatever beta and gamma."""
    bounded = paper.with_values({("bouc_wen", "gamma"): -0.005})
    u = 75.0 * np.sin(np.arange(2000) / 1000.0 * np.pi)
    for model, symmetric in ((bounded, True), (bounded.with_link(LINK, **VALUES), False)):
        x = simulate(model, u, 1e-2, hold=Hold.FIRST, initial=Initial.PERIODIC)
        x = x - x.mean()
        oddness = np.max(np.abs(x[:1000] + x[1000:])) / np.ptp(x)
        assert oddness < 1e-6 if symmetric else oddness > 5e-3


def loops(kind: str, u: Array, share: float = 0.3) -> Array:
    """Free displacement after other people's equations for h, by small midpoint steps, m."""
    d, alpha, beta, gamma, parts = 1.4447e-7, 0.0801, 0.0152, -0.0227, 20

    def rate(h: float, v: float, sign: float) -> float:
        """dh/du in the direction `sign`, times `sign`."""
        a, b, extra = alpha, beta, 0.0
        if kind == "zhu and wang":
            extra = share * alpha * d * v / 80.0
        elif kind == "song and der kiureghian":
            extra = share * (0.6 * sign * h - abs(h))
        elif kind == "alpha by direction":
            a = alpha * (1.0 + share * sign)
        elif kind == "beta by direction":
            b = beta * (1.0 + 0.4 * sign)
        return sign * a * d - b * h - sign * gamma * abs(h) + extra

    h, old, w = 0.0, 0.0, []
    for new in u:
        step = (new - old) / parts
        way, sign = abs(step), np.sign(step)
        for i in range(parts):
            middle = h + 0.5 * way * rate(h, old + step * i, sign)
            h += way * rate(middle, old + step * (i + 0.5), sign)
        old = new
        w.append(d * new - h)
    if kind == "unlike envelopes":
        w = list(np.array(w) + 0.3 * d * unlike_plays(u))
    return np.array(w)


def unlike_plays(u: Array) -> Array:
    """The mean of three generalised plays: the falling edge a power of the voltage, V."""
    plays = []
    for threshold in (4.0, 14.0, 30.0):
        y = [0.0]
        for v in u:
            y.append(max(v - threshold, min(150.0 * (v / 150.0) ** 0.72 + threshold, y[-1])))
        plays.append(y[1:])
    return np.mean(plays, axis=0)


@pytest.mark.parametrize("share", [1e-3, 0.5, -1.2])
def test_zhu_and_wang_s_term_is_delta(paper: Model, share: float) -> None:
    """However strong, through turns and changes of sign of h, also where the sum's sign differs."""
    t = np.arange(600) / 100.0
    u = 80.0 * (1.0 - np.cos(2.0 * np.pi * t)) * (0.3 + 0.7 * t / t[-1])
    expected = loops("zhu and wang", u, share) - loops("zhu and wang", u, 0.0)
    alone = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0}
    rig = paper.with_link(LINK, **alone, delta=share * 0.0801 * 1.4447e-7 / 80.0)
    x, plain = (simulate(model, np.append(u, u[-1]), 1e-2)[1:] for model in (rig, paper))
    found = (x - plain) * (5e7 + 8.2e5) / 5e7
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2e-3 * np.ptp(expected))


@pytest.mark.parametrize("share", [1e-4, 3e-3, -2e-2])
def test_song_and_der_kiureghian_s_terms_are_rates_by_direction(paper: Model, share: float) -> None:
    t = np.arange(600) / 100.0
    u = 80.0 * (1.0 - np.cos(2.0 * np.pi * t)) * (0.3 + 0.7 * t / t[-1])
    kind = "song and der kiureghian"
    expected = loops(kind, u, share) - loops(kind, u, 0.0)
    alone = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0, "delta": 0.0}
    rig = paper.with_link(LINK, **alone, onward=0.4 * share, backward=-1.6 * share)
    x, plain = (simulate(model, np.append(u, u[-1]), 1e-2)[1:] for model in (rig, paper))
    found = (x - plain) * (5e7 + 8.2e5) / 5e7
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2e-3 * np.ptp(expected))


def test_jumps_are_many_small_steps(paper: Model) -> None:
    """Jumps across zeros of h and of h + z, and rests between them, in which nothing is new."""
    levels = np.random.default_rng(4).uniform(0.0, 160.0, 30)
    alone = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0}
    rig = paper.with_link(LINK, **alone, delta=-8e-11)
    steps = 500
    way = np.interp(np.arange(29 * steps + 1) / steps, np.arange(30.0), levels)
    x = simulate(rig, np.repeat(levels, 3), 1e-2, initial=Initial.FIRST_SAMPLE)[3::3]
    slow = simulate(rig, way, 1e-2, initial=Initial.FIRST_SAMPLE)[1::steps]
    np.testing.assert_allclose(x, slow[: len(x)], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize(
    ("kind", "left"),
    [
        ("zhu and wang", 0.01),
        ("alpha by direction", 0.2),
        ("beta by direction", 0.2),
        ("unlike envelopes", 0.25),
    ],
)
def test_other_people_s_asymmetry_is_taken_up(paper: Model, kind: str, left: float) -> None:
    """After a refit with the link less than `left` of what the paper's h cannot follow remains."""
    t = np.arange(600) / 100.0
    u = 80.0 * (1.0 - np.cos(2.0 * np.pi * t)) * (0.3 + 0.7 * t / t[-1])
    measured = loops(kind, u)
    gain = 5e7 / (5e7 + 8.2e5)
    rig = paper.with_link(LINK)
    if kind == "unlike envelopes":
        scales = Scales(1e-2, 6.0, (0.0, 160.0), 1e3, (0.0, STROKE), 5e7, 0.0038)
        starts = [start for start in link_named(LINK).starts(scales) if start.get("plays")]
        rig = paper.with_link(LINK, **[one for one in starts if not one.get("relative")][-1])

    def remaining(model: Model) -> float:
        keys = [
            (link, name)
            for link in ("bouc_wen", LINK)
            if link in model.settings
            for name in model.values(link)
            if link_named(link).parameter(name).fitted
            and name not in link_named(link).idle(model.values(link))
        ]
        declared = [link_named(link).parameter(name) for link, name in keys]
        sizes = [model.value(*key) or one.high for key, one in zip(keys, declared, strict=True)]
        scales = np.abs(sizes)
        bounds = [p.low for p in declared] / scales, [p.high for p in declared] / scales

        def residual(z: Array) -> Array:
            changed = model.with_values(dict(zip(keys, (z * scales).tolist(), strict=True)))
            x = simulate(changed, np.append(u, u[-1]), 1e-2)[1:] / gain - measured
            return (x - x.mean()) / STROKE

        start = np.sign([model.value(*key) for key in keys])
        best = least_squares(residual, start, bounds=bounds, x_scale="jac", max_nfev=60)
        return float(np.sqrt(2.0 * best.cost / len(u)))

    plain = remaining(paper)
    assert plain > 3e-3
    assert remaining(rig) < left * plain


def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    planted = {n: VALUES[n] for n in VALUES if n not in ("beta", "gamma")} | {"delta": 2e-11}
    truth = np.array(list(planted.values()))
    rig = paper.with_link(LINK, **planted)
    start = {"tilt": 1e-9, "bulge": -1e-11, "twist": 1e-13, "skew": 5e-8, "reach": 20.0}
    start |= {"delta": 1e-11}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.2 * np.abs(truth))


def test_a_planted_loop_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    planted = {"delta": -4e-11, "beta": 0.0152, "gamma": -0.0227}
    rig = paper.with_link(LINK, tilt=0.0, bulge=0.0, twist=0.0, skew=0.0, **planted)
    start = {"delta": -2e-11, "beta": 0.014, "gamma": -0.021}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    truth = np.array(list(planted.values()))
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.05 * np.abs(truth))


BENT = {
    "plays": 5e-8,
    "widest": 40.0,
    "taper": 0.5,
    "rise_bow": -6.0,
    "rise_skew": -3.0,
    "rise_curl": 2.0,
    "fall_bow": 9.0,
    "fall_skew": 4.0,
    "fall_curl": -5.0,
}
ONLY_PLAYS = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0, "delta": 0.0} | BENT


@pytest.mark.parametrize("relative", [False, True])
def test_plays_follow_their_edges_up_and_down(paper: Model, relative: bool) -> None:
    """From rest up each is as far as its edge has ever been, and down again likewise."""
    rise, fall = np.arange(0.0, 131.0, 0.5), np.arange(130.0, -0.1, -0.5)
    u = np.append(rise, fall)
    p = 1.0 - 2.0 * u / 150.0
    up = u + (-6.0 - 3.0 * p + 2.0 * p**3) * (1.0 - p**2)
    down = u + (9.0 + 4.0 * p - 5.0 * p**3) * (1.0 - p**2)
    expected = followed(up, down, len(rise))
    expected -= followed(0.5 * (up + down), 0.5 * (up + down), len(rise)) if relative else u
    plays = ONLY_PLAYS | {"relative": float(relative)}
    x = simulate(paper.with_link(LINK, **plays), u, 0.1, hold=Hold.FIRST)
    x -= simulate(paper, u, 0.1, hold=Hold.FIRST)
    found = x * (5e7 + 8.2e5) / 5e7
    np.testing.assert_allclose(found, 5e-8 * expected, rtol=0.0, atol=1e-10)


def followed(up: Array, down: Array, turn: int) -> Array:
    """Where the plays are on average, V: up along one edge until `turn`, then down the other."""
    total, whole = np.zeros(len(up)), 0.0
    for place in np.arange(0.5, 8.0) / 8.0:
        rising = np.maximum(0.0, np.maximum.accumulate(up[:turn] - 40.0 * place))
        falling = np.minimum(rising[-1], np.minimum.accumulate(down[turn:] + 40.0 * place))
        total += np.exp(-0.5 * place) * np.append(rising, falling)
        whole += np.exp(-0.5 * place)
    return total / whole


@pytest.mark.parametrize(
    ("risen", "fallen", "side"), [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.0, 1.0, -1.0)]
)
def test_where_plays_begin_is_told_by_the_way(risen: float, fallen: float, side: float) -> None:
    levels = np.zeros(LEVELS)
    levels[VOLTAGE] = 150.0  # there the edges do not bend
    levels[HIGH + VOLTAGE] = 250.0
    levels[[RISEN, FALLEN]] = risen, fallen
    prepared = link_named(LINK).prepare(NOMINAL | BENT, Timing(1e-3, (1e-3,), False), levels)
    np.testing.assert_allclose(
        prepared.state[6:14], 150.0 - side * 40.0 * np.arange(0.5, 8.0) / 8.0
    )


@pytest.mark.parametrize(
    ("rise", "fall", "unusual"),
    [
        (0.0, 12.0, 0.0),
        (0.0, -12.0, 0.0),
        (12.0, 7.0, 0.0),
        (0.0, 3.0, 3.0),
        (0.0, 0.0, 3.0),
        (40.0, 33.0, 3.0),
    ],
)
def test_plays_with_edges_that_are_straight_or_alike_are_no_lopsided_loop(
    rise: float, fall: float, unusual: float
) -> None:
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 150.0, (0.0, STROKE), 5e7, 0.0038)
    unbent = dict.fromkeys(("rise_skew", "rise_curl", "fall_skew", "fall_curl"), 0.0)
    shape = unbent | {"rise_bow": rise, "fall_bow": fall}
    link = link_named(LINK)
    assert link.unusual(NOMINAL | BENT | shape, scales) == pytest.approx(unusual)
    assert link.unusual(NOMINAL | shape, scales) == 0.0
    assert link.unusual(NOMINAL | BENT | shape | {"relative": 1.0}, scales) == 0.0


@pytest.mark.parametrize("relative", [0.0, 1.0])
@pytest.mark.parametrize(("taper", "unusual"), [(0.5, 0.0), (10.0, 3.0)])
def test_plays_whose_edges_cross_are_a_bent_line(
    paper: Model, relative: float, taper: float, unusual: float
) -> None:
    """All but the widest then lie on one edge, both ways: what they do is hardly a loop."""
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 150.0, (0.0, STROKE), 5e7, 0.0038)
    crossed = ONLY_PLAYS | {"rise_bow": 12.0, "fall_bow": -14.0, "fall_skew": -6.0, "taper": taper}
    crossed |= {"widest": 30.0 if taper == 0.5 else 15.0, "relative": relative}
    assert link_named(LINK).unusual(NOMINAL | crossed, scales) == pytest.approx(unusual)
    u = 75.0 - 75.0 * np.cos(np.arange(2000) * np.pi / 500.0)
    settled = {"hold": Hold.FIRST, "initial": Initial.PERIODIC}
    x = simulate(paper.with_link(LINK, **crossed), u, 1e-2, **settled)  # type: ignore[arg-type]
    x -= simulate(paper, u, 1e-2, **settled)  # type: ignore[arg-type]
    rise, fall = x[:500], x[999:499:-1]
    straight = np.polyval(np.polyfit(u[:500], 0.5 * (rise + fall), 1), u[:500])
    line = np.std(0.5 * (rise + fall) - straight)
    assert (np.std(fall - rise) < line) == (unusual > 0.0)


@pytest.mark.parametrize("relative", [0.0, 1.0])
def test_planted_plays_are_found(
    paper: Model,
    lively: Array,
    recover: Callable[..., tuple[Array, Array]],
    relative: float,
) -> None:
    rig = paper.with_link(LINK, **ONLY_PLAYS, relative=relative)
    start = BENT | {"plays": 4e-8, "widest": 35.0, "rise_bow": -3.0, "fall_bow": 5.0}
    idle = set(link_named(LINK).idle(NOMINAL | BENT | {"relative": relative}))
    assert idle & set(BENT) == (set() if relative else {"rise_curl", "fall_curl"})
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    truth = np.array(list(BENT.values()))
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    # Where they are relative, a bend that both edges share hardly shows.
    sharp = errors < 0.3 * np.abs(truth)
    assert np.all(sharp[:3] if relative else sharp)


@pytest.mark.parametrize("reach", [12.0, 80.0, 300.0])
def test_it_tells_how_far_the_branches_of_a_loop_are_apart(paper: Model, reach: float) -> None:
    values = NOMINAL | VALUES | {"reach": reach}
    scales = Scales(1e-2, 10.0, (-20.0, 130.0), 100.0, (0.0, STROKE), 5e7, 0.0038)
    rise = np.linspace(-20.0, 130.0, 1500, endpoint=False)
    loop = np.append(rise, -20.0 + 130.0 - rise)
    settled = {"hold": Hold.FIRST, "initial": Initial.PERIODIC}
    x = simulate(paper.with_link(LINK, **values), loop, 1e-2, **settled)  # type: ignore[arg-type]
    x -= simulate(paper, loop, 1e-2, **settled)  # type: ignore[arg-type]
    u, up = np.linspace(-20.0, 130.0, 50), np.interp(np.linspace(-20.0, 130.0, 50), rise, x[:1500])
    down = np.interp(u, loop[:1499:-1], x[:1499:-1])
    expected = (5e7 + 8.2e5) / 5e7 * (down - up)
    found = link_named(LINK)
    np.testing.assert_allclose(
        apart(values, scales)[1:-1], expected[1:-1], rtol=0.0, atol=2e-3 * np.ptp(expected)
    )
    share = np.max(np.abs(expected)) / STROKE
    assert f"{100.0 * share:.2g} % of the stroke" in found.says(values, scales)


def test_what_grows_from_round_to_round_is_not_told() -> None:
    """A fit once ended there: with such a memory z overflows in loops of 150 V."""
    values = NOMINAL | VALUES | {"delta": -1.5e-13, "beta": 0.3, "gamma": -0.5}
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 150.0, (0.0, STROKE), 5e7, 0.0038)
    np.testing.assert_array_equal(apart(values, scales), apart(values | {"delta": 0.0}, scales))
    assert np.all(np.isfinite(apart(values, scales)))


def test_plays_that_go_beyond_the_stroke_are_told_as_they_are(paper: Model) -> None:
    """There is no z to leave out."""
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 1e3, (0.0, 2e-5), 5e7, 0.0038)
    far = paper.with_link("asymmetric_hysteresis", plays=5e-5, rise_bow=30.0)
    values = far.values("asymmetric_hysteresis")
    assert np.max(np.abs(apart(values, scales))) > 2e-5


def test_a_bent_line_does_not_pass_for_a_loop() -> None:
    """With a reach far beyond the swing s is the voltage: a polynomial without any hysteresis."""
    scales = Scales(1e-3, 10.0, (0.0, 100.0), 100.0, (0.0, STROKE), 5e7, 0.0038)
    least, most = link_named(LINK).plausible(scales)["reach"]
    starts = [start for start in link_named(LINK).starts(scales) if "reach" in start]
    assert all(least < start["reach"] < most for start in starts)
    assert 1.0 - np.exp(-100.0 / most) > 0.8  # of a turn is forgotten within the swing
