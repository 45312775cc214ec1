"""Identification of 44 000 samples, against a script with an integrator and against evolution."""

from __future__ import annotations

import time
from functools import partial

from microgripper_control.bench import rig
from microgripper_control.bench.rivals.scripted import Script
from microgripper_control.bench.rivals.scripted_fit import (
    KEYS,
    compiled_model,
    evolution_script,
    least_squares_script,
)
from microgripper_control.bench.row import FASTER, Effort, Line, Measured, Row, at_least, at_most
from microgripper_control.bench.rows.simulation import SHORT, choose_solve_ivp
from microgripper_control.bench.timing import Contestant, Spread, take_turns
from microgripper_control.identification.fit import fit
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial

LONGEST = at_most(1.0)  # s
TIMES = at_least(200.0)
CONDITIONS = Conditions(initial=Initial.REST)


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    recording = rig.recording(nominal_model())
    start = rig.mistuned(nominal_model())
    ours = partial(fit, start, [recording], CONDITIONS)
    unknown = partial(fit, start, [recording])  # the state it starts in is fitted, too
    script = Script(rig.nominal_values(), recording.voltage[:SHORT], rig.SAMPLE_PERIOD)
    scripted = choose_solve_ivp(script)
    simulator = compiled_model(recording)
    asked = least_squares_script(start, recording, simulator).simulations
    times = take_turns(
        {
            "ours": Contestant(ours),
            "unknown": Contestant(unknown),
            "quick script": Contestant(partial(least_squares_script, start, recording, simulator)),
            "solve_ivp": Contestant(scripted.solve, SHORT),
        },
        effort.few_rounds,
    )
    began = time.perf_counter()
    evolution = evolution_script(start, recording, simulator)
    evolved = time.perf_counter() - began
    whole = asked * len(recording) * times.rounds["solve_ivp"]
    spent, median = times.rounds["ours"], times.of("ours").median
    found = len(ours().determined)
    what = f"fit of {len(recording)} samples, {found} parameters and the zero"
    lines = (
        Line(what, "", times.of("ours"), "s", LONGEST),
        Line(f"{what} and the initial state", "", times.of("unknown"), "s", LONGEST),
        Line(
            what,
            f"the same scripted: {scripted.about} and finite differences",
            Spread.of(whole / spent),
            FASTER,
            TIMES,
            median,
            times.of("solve_ivp").median * asked * len(recording),
        ),
        Line(
            what,
            f"differential evolution on our compiled model, {evolution.simulations} simulations",
            Spread.of(evolved / spent),
            FASTER,
            None,
            median,
            evolved,
        ),
        Line(
            what,
            f"least squares on our compiled model, {asked} simulations",
            times.ratio("quick script", "ours"),
            FASTER,
            None,
            median,
            times.of("quick script").median,
        ),
    )
    note = (
        f"The start is 10 % off in {', '.join(name for _, name in KEYS)}. Ours includes a search "
        "for the basin, a simplex, the test of what the data determine and intervals; the scripts "
        f"descend once. The script with solve_ivp would take its {asked} simulations (counted with "
        f"the compiled model in its place) times {len(recording)} samples; its time per sample is "
        f"that of {SHORT} samples, on which it is off by {1e9 * scripted.error:.2g} nm rms."
    )
    return Measured(lines, (note,))


ROW = Row("identification", "identification of 44 000 samples", measure)
