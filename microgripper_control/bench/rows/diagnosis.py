"""A whole diagnosis of two recordings, against their length and the textbook's selection."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.row import LONGER, Effort, Line, Measured, Row, at_most
from microgripper_control.bench.timing import Spread
from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.diagnose import diagnose
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.examination.beside.evidence import Begun
from microgripper_control.examination.beside.grey_box import select
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model

QUARTER, FIVE_TIMES = at_most(0.25), at_most(5.0)
PLANTED = "creep"
CORES = 2
PACES = (1.0, 3.7)  # of the two recordings' voltages


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    rig_with_gap = nominal_model().with_link(PLANTED)
    recordings = [
        rig.recording(rig_with_gap, seed=seed, pace=pace) for seed, pace in enumerate(PACES)
    ]
    believed = rig.mistuned(nominal_model())
    recorded = sum(recording.duration for recording in recordings)
    ours, baseline = [], []
    for turn in range(effort.among(3, 1)):
        effort.progress(f"diagnosis, turn {turn + 1}")
        began = time.perf_counter()
        found = diagnose(believed, recordings, jobs=CORES)
        between = time.perf_counter()
        textbook(believed, recordings)
        ours.append(between - began)
        baseline.append(time.perf_counter() - between)
    spent, others = np.array(ours), np.array(baseline)
    what = f"diagnosis of two recordings of {recordings[0].duration:.0f} s, {CORES} cores"
    median, theirs = float(np.median(spent)), float(np.median(others))
    lines = (
        Line(what, "the recorded time", Spread.of(spent / recorded), LONGER, QUARTER, median),
        Line(
            what,
            "the textbook's selection (BIC over refits), one core",
            Spread.of(spent / others),
            LONGER,
            FIVE_TIMES,
            median,
            theirs,
        ),
    )
    named = ", ".join(found.effects) or found.verdict
    note = f"Planted was {PLANTED}, the model is 10 % off besides; the diagnosis said {named}."
    return Measured(lines, (note,))


def textbook(model: Model, recordings: Sequence[Recording]) -> str:
    """What the smallest BIC names: the baseline of the check on withheld effects."""
    evidence = Evidence.gather(recordings, (), Conditions(), model)
    before = nominal_trial(evidence, model)
    answer, _, _ = select(Begun(evidence, before, refit_trial(evidence, before)))
    return answer


ROW = Row("diagnosis", "a whole diagnosis", measure)
