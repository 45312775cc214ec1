"""Simulating the nominal chain, per sample, against scipy's integrators, numpy and C."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.rivals import in_c
from microgripper_control.bench.rivals.scripted import Script, numpy_loop
from microgripper_control.bench.row import FASTER, Effort, Line, Measured, Row, at_least
from microgripper_control.bench.timing import Contestant, take_turns
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
# Loosest first. With one step a sample, which ends at none of the corners of the voltage, the error
# is anything from 0.4 to 5 nm rms however tight they are: of a coarse grid none may be good enough.
RTOLS = (*(float(f"{a}e-{b}") for b in range(2, 7) for a in (1.0, 0.5, 0.2)), 1e-9, 1e-12)
ATOLS = (*(float(f"{a}e-{b}") for b in range(1, 6) for a in (1.0, 0.5, 0.2)), 1e-6, 1e-8)  # um
ACCURACY = 1e-9  # m: what an integrator may be off by, rms
SHORT = 3000  # samples, for the slow rivals; on fewer a loose tolerance may be lucky
STRETCH = 50  # of them, on which their settings are compared
TRIES = 2  # of which the faster counts
GOALS = {"solve_ivp": at_least(100.0), "odeint": at_least(20.0), "C": at_least(0.8)}


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    long = rig.voltage()
    short = long[:SHORT]
    values, step, model = rig.nominal_values(), rig.mechanics_step(), nominal_model()
    script = Script(values, short, rig.SAMPLE_PERIOD)
    solve_ivp, odeint = choose_solve_ivp(script), choose_odeint(script)
    held, straight = "ours, held", "ours, straight"
    contestants = {
        held: Contestant(lambda: simulate(model, long, rig.SAMPLE_PERIOD), len(long)),
        straight: Contestant(
            lambda: simulate(model, long, rig.SAMPLE_PERIOD, hold=Hold.FIRST), len(long)
        ),
        "solve_ivp": Contestant(solve_ivp.solve, len(short)),
        "odeint": Contestant(odeint.solve, len(short)),
        "numpy": Contestant(lambda: numpy_loop(values, step, short), len(short)),
    }
    about = {
        "solve_ivp": f"scipy {solve_ivp.about}",
        "odeint": f"scipy {odeint.about}",
        "numpy": "a plain numpy loop",
    }
    pairs = {"solve_ivp": straight, "odeint": straight, "numpy": held}
    cc, skipped, room = in_c.compiler(), "", np.empty_like(long)
    if cc is None:
        skipped = " No C compiler was found: not compared with C."
    else:
        for name, options in {"C": (), "C, native": ("-march=native",)}.items():
            chain = in_c.ChainInC(effort.folder, cc, bouc_wen_numbers(), step, options)
            contestants[name] = Contestant(partial(chain.simulate, long, room), len(long))
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
        f"{len(short)}. The voltage runs straight between the samples for the "
        "integrators, and is held for the loop and C. Ours is exact up to rounding; of each "
        f"integrator the fastest of {len(RTOLS)} rtol by {len(ATOLS)} atol, and of solve_ivp's "
        "methods, that is off by at most 1 nm rms on these samples is taken, which favours it, as "
        f"on others it need not be: solve_ivp is off by {1e9 * solve_ivp.error:.2g} nm, odeint by "
        f"{1e9 * odeint.error:.2g} nm." + skipped
    )
    return Measured(tuple(lines), (note,))


def bouc_wen_numbers() -> Array:
    """d, alpha d, beta, gamma of the nominal chain."""
    v = rig.nominal_values()
    return np.array([v["d"], v["alpha"] * v["d"], v["beta"], v["gamma"]])


def exact(script: Script) -> Array:
    """What a script is measured against: ours, m."""
    return simulate(nominal_model(), script.voltage, script.sample_period, hold=Hold.FIRST)


class Chosen(NamedTuple):
    """An integrator with the settings that suit it best, and how far off it then is, m rms."""

    about: str
    solve: Callable[[], Array]
    error: float

    @classmethod
    def of(cls, about: str, solve: Callable[[], Array], truth: Array) -> Chosen:
        """Measured against what is true, m; NaN if it fails."""
        return cls(about, solve, float(np.sqrt(np.mean((solve() - truth) ** 2))))


def choose_solve_ivp(script: Script) -> Chosen:
    """The fastest method and tolerances that are accurate enough."""
    return _fastest(
        script,
        {f"solve_ivp, {method}": partial(Script.solve_ivp, method=method) for method in METHODS},
    )


def choose_odeint(script: Script) -> Chosen:
    """The fastest tolerances that are accurate enough."""
    return _fastest(script, {"odeint": Script.odeint})


def _fastest(script: Script, methods: Mapping[str, Callable[..., Array]]) -> Chosen:
    """The fastest on a stretch of the script of those that are accurate enough on all of it.

    Errors do not fall steadily with the tolerances, and looser ones are not always faster: so each
    is tried, unless its method is slower at the loosest than the best so far. MicrogripperError
    where none is accurate enough.
    """
    stretch, truth = replace(script, voltage=script.voltage[:STRETCH]), exact(script)
    loosest = {
        name: _seconds(partial(solve, rtol=RTOLS[0], atol=ATOLS[0]), stretch)
        for name, solve in methods.items()
    }
    best, least = None, np.inf
    for name in sorted(methods, key=loosest.__getitem__):
        if loosest[name] > least:
            break
        ways = _ways(name, methods[name])
        spent = {about: _seconds(solve, stretch) for about, solve in ways.items()}
        faster = sorted((x for x in ways if spent[x] < least), key=spent.__getitem__)
        tried = (Chosen.of(about, partial(ways[about], script), truth) for about in faster)
        found = next((one for one in tried if one.error <= ACCURACY), None)
        if found is not None:
            best, least = found, spent[found.about]
    if best is None:
        integrator = next(iter(methods)).split(",")[0]
        raise MicrogripperError(
            f"bench: {integrator} is within {ACCURACY:g} m rms at none of its settings"
        )
    return best


def _ways(name: str, solve: Callable[..., Array]) -> dict[str, Callable[[Script], Array]]:
    """A method at each of the tolerances."""
    return {
        f"{name}, rtol {rtol:g}, atol {atol:g} um": partial(solve, rtol=rtol, atol=atol)
        for rtol, atol in product(RTOLS, ATOLS)
    }


def _seconds(solve: Callable[[Script], Array], script: Script) -> float:
    times = []
    for _ in range(TRIES):
        start = time.perf_counter()
        solve(script)
        times.append(time.perf_counter() - start)
    return min(times)


ROW = Row("simulation", "simulating the nominal chain", measure)
