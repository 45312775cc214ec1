"""Simulating the nominal chain, per sample, against scipy's integrators, numpy and C."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.rivals import in_c
from microgripper_control.bench.rivals.scripted import Script, numpy_loop
from microgripper_control.bench.row import FASTER, Effort, Line, Measured, Row, at_least
from microgripper_control.bench.timing import Contestant, take_turns
from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
ACCURACY = 1e-9  # m: what an integrator's error may be at most
SHORT = 300  # samples, for the integrators
LOOPED = 3000  # samples, for the numpy loop
GOALS = {"solve_ivp": at_least(100.0), "odeint": at_least(20.0), "C": at_least(0.8)}


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    long = rig.voltage()
    short, loop = long[:SHORT], long[:LOOPED]
    values, step, model = rig.nominal_values(), rig.mechanics_step(), nominal_model()
    script = Script(values, short, rig.SAMPLE_PERIOD)
    method, tolerance = choose_solve_ivp(script)
    tight = choose_odeint(script)
    held, straight = "ours, held", "ours, straight"
    contestants = {
        held: Contestant(lambda: simulate(model, long, rig.SAMPLE_PERIOD), len(long)),
        straight: Contestant(
            lambda: simulate(model, long, rig.SAMPLE_PERIOD, hold=Hold.FIRST), len(long)
        ),
        "solve_ivp": Contestant(lambda: script.solve_ivp(method, tolerance), len(short)),
        "odeint": Contestant(lambda: script.odeint(tight), len(short)),
        "numpy": Contestant(lambda: numpy_loop(values, step, loop), len(loop)),
    }
    about = {
        "solve_ivp": f"scipy solve_ivp, {method}, rtol {tolerance:g}",
        "odeint": f"scipy odeint, rtol {tight:g}",
        "numpy": "a plain numpy loop",
    }
    pairs = {"solve_ivp": straight, "odeint": straight, "numpy": held}
    cc, skipped = in_c.compiler(), ""
    if cc is None:
        skipped = " No C compiler was found: not compared with C."
    else:
        for name, options in {"C": (), "C, native": ("-march=native",)}.items():
            chain = in_c.ChainInC(effort.folder, cc, bouc_wen_numbers(), step, options)
            contestants[name] = Contestant(partial(chain.simulate, long), len(long))
            about[name] = f"by hand in C, {' '.join(('-O3', *options))}"
            pairs[name] = held
    times = take_turns(contestants, effort.rounds)
    lines = [
        Line(
            "nominal chain, per sample",
            about[name],
            times.ratio(name, ours),
            FASTER,
            GOALS.get(name),
            times.of(ours).median,
            times.of(name).median,
        )
        for name, ours in pairs.items()
    ]
    note = (
        f"{len(long)} samples at 1 kHz; the integrators and the loop run on their first "
        f"{len(short)} and {len(loop)}. The voltage runs straight between the samples for the "
        "integrators, and is held for the loop and C. Ours is exact up to rounding; of each "
        "integrator the fastest method and tolerance that is within 1 nm is taken, which favours "
        "it." + skipped
    )
    return Measured(tuple(lines), (note,))


def bouc_wen_numbers() -> Array:
    """d, alpha d, beta, gamma of the nominal chain."""
    v = rig.nominal_values()
    return np.array([v["d"], v["alpha"] * v["d"], v["beta"], v["gamma"]])


def exact(script: Script) -> Array:
    """What a script is measured against: ours, m."""
    return simulate(nominal_model(), script.voltage, script.sample_period, hold=Hold.FIRST)


def choose_solve_ivp(script: Script) -> tuple[str, float]:
    """The fastest method with the loosest of the tolerances that is accurate enough."""
    found = []
    for method in METHODS:
        solve = partial(script.solve_ivp, method)
        found += [(seconds, method, tolerance) for tolerance, seconds in _accurate(script, solve)]
    _, method, tolerance = min(found)
    return method, tolerance


def choose_odeint(script: Script) -> float:
    """The loosest tolerance at which odeint is accurate enough."""
    return next(_accurate(script, script.odeint))[0]


def _accurate(script: Script, solve: Callable[[float], Array]) -> Iterator[tuple[float, float]]:
    """The loosest tolerance that is accurate enough, if one is, and the time it took, s."""
    truth = exact(script)
    for tolerance in TOLERANCES:
        start = time.perf_counter()
        off = np.max(np.abs(solve(tolerance) - truth))
        if off <= ACCURACY:
            yield tolerance, time.perf_counter() - start
            return


ROW = Row("simulation", "simulating the nominal chain", measure)
