"""The next experiment: the voltage on which explanations that are equally good come apart most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.quantities import number, quantity
from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.experiments.excitations import Excitation, Reach, excitations
from microgripper_control.diagnosis.experiments.rehearsal import Apart, Rehearsal, Rival, rivals_of
from microgripper_control.diagnosis.findings import NextExperiment
from microgripper_control.effects.base import Stage
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model

LONGEST = 20.0  # s
MOST_SAMPLES = 40_000
SMOOTH_EDGE = 20  # samples, where the voltage runs smoothly between them
MOST_STROKE = 1.2  # of the recorded one: an experiment must not shake the rig apart
FEWEST_SAMPLES = 100
VISIBLE = 0.3  # of the noise: less is not seen for sure,
BARELY = 0.01  # and of less nobody need know how much it is
FINEST = 1e-6  # of the stroke: what counts as noise where there is none

Pair = tuple[int, int]
Table = Mapping[Pair, Apart]

# Where to measure as well, if the voltage alone cannot tell an effect there from a later one.
BEHIND = {
    Stage.DRIVE: "the voltage at the stack itself",
    Stage.MATERIAL: "the elongation of the stack itself",
    Stage.MECHANICS: "the displacement ahead of the finger's joint",
    Stage.TRANSMISSION: "the finger with a second sensor",
}


def next_experiment(
    rivals: Sequence[Model], recording: Recording, conditions: Conditions, noise: float
) -> NextExperiment | None:
    """The voltage that would best tell fitted models apart, the most probable one first.

    It stays within the recording's and the models' range of voltage, and so slow that the
    recording's sample period shows it, and moves the rig little further than it has moved
    (MOST_STROKE). `noise` is the noise floor, m. None with fewer than two rivals, or where nothing
    of that kind can be made.
    """
    reach = _reach(rivals, recording, conditions)
    if reach is None:
        return None
    known = rivals_of(rivals, recording, conditions)
    hold = Hold.ZERO if conditions.hold is Hold.ZERO else Hold.FIRST
    stroke = float(np.ptp(recording.measured))
    noise = max(noise, FINEST * stroke)
    tried: list[tuple[Excitation, Table]] = []
    for excitation in excitations(reach):
        rehearsal = Rehearsal.of(known, excitation.voltage, reach.sample_period, hold)
        if rehearsal.within(MOST_STROKE * stroke):
            tried.append((excitation, rehearsal.separations()))
    if not tried:
        return None
    told = _told([table for _, table in tried], noise)
    shown = [one for one in tried if _shows(one[1], told, noise)]
    best, table = max(shown, key=lambda one: _score(one[1], told))
    return NextExperiment(
        why=_why(best, table, told, known, noise),
        separates=_separated(told, table, known),
        sample_period=reach.sample_period,
        voltage=best.voltage,
    )


def _reach(rivals: Sequence[Model], recording: Recording, conditions: Conditions) -> Reach | None:
    if len(rivals) < 2:
        return None
    low = max([float(np.min(recording.voltage)), *(model.voltage_range[0] for model in rivals)])
    high = min([float(np.max(recording.voltage)), *(model.voltage_range[1] for model in rivals)])
    samples = min(MOST_SAMPLES, int(LONGEST / recording.sample_period))
    if not low < high or samples < FEWEST_SAMPLES:
        return None
    edge = 1 if conditions.hold is Hold.ZERO else SMOOTH_EDGE
    return Reach(low, high, recording.sample_period, samples, edge)


def _told(tables: Sequence[Table], noise: float) -> list[Pair]:
    """The pairs that one excitation shows together; a pair of more probable rivals comes first."""
    told: list[Pair] = []
    for pair in sorted(tables[0]):
        if any(_shows(table, [*told, pair], noise) for table in tables):
            told.append(pair)
    return told


def _shows(table: Table, pairs: Sequence[Pair], noise: float) -> bool:
    return all(table[pair].rms >= VISIBLE * noise for pair in pairs)


def _score(table: Table, pairs: Sequence[Pair]) -> float:
    """m: the smallest separation of some pairs, of all if there are none.

    A pair counts the less, the less probable its better one is.
    """
    return min(table[pair].rms * (1.0 + pair[0]) for pair in pairs or table)


def _separated(told: Sequence[Pair], table: Table, rivals: Sequence[Rival]) -> tuple[str, ...]:
    """The effects of the pairs that are told apart, but those that may be there or not for all."""
    together = sorted({index for pair in told for index in pair})
    names = dict.fromkeys(name for index in together for name in rivals[index].effects)
    untold = [
        set(rivals[a].effects) ^ set(rivals[b].effects) for a, b in table if (a, b) not in told
    ]
    return tuple(name for name in names if {name} not in untold)


def _why(
    excitation: Excitation,
    table: Table,
    told: Sequence[Pair],
    rivals: Sequence[Rival],
    noise: float,
) -> str:
    """What to record and what would be seen, or that nothing would be."""
    sentences = _seen(excitation, table, told, rivals, noise) if told else []
    unseen: dict[str, list[Pair]] = {}
    for pair in (pair for pair in table if pair not in told):
        unseen.setdefault(_remedy(*(rivals[index] for index in pair)), []).append(pair)
    for remedy, pairs in unseen.items():
        names = " or ".join(f"{_name(rivals[a])} from {_name(rivals[b])}" for a, b in pairs)
        largest = max(table[pair].rms for pair in pairs) / noise
        times = number(largest, 1) if largest > BARELY else f"less than {BARELY:g}"
        apart = f"{times} times the noise between them{' at most' if len(pairs) > 1 else ''}"
        if told:
            sentences.append(f"it will hardly tell {names} ({apart}); {remedy}.")
        else:
            by = excitation.description
            sentences.append(f"no voltage within reach tells {names} ({by}: {apart}); {remedy}.")
    return " ".join(sentence[0].upper() + sentence[1:] for sentence in sentences)


def _seen(
    excitation: Excitation,
    table: Table,
    told: Sequence[Pair],
    rivals: Sequence[Rival],
    noise: float,
) -> list[str]:
    """What to record, what tells the closest of some pairs apart, and what it asks for."""
    least = min(told, key=lambda pair: table[pair].rms)
    apart, (first, second) = table[least], least
    wrong = second if apart.true == first else first
    both = f"{_name(rivals[first])} and {_name(rivals[second])} come apart least: "
    seen = (
        f"record {excitation.description}: {both if len(told) > 1 else ''}if it is "
        f"{_name(rivals[apart.true])}, the displacement will differ from all that "
        f"{_name(rivals[wrong])} can give by {quantity(apart.rms, 'm')} rms, "
        f"{number(apart.rms / noise)} times the noise, and by {quantity(apart.largest, 'm')} "
        f"at {quantity(apart.time, 's', 3)}."
    )
    if excitation.fastest == 0.0:
        return [seen]
    step = quantity(excitation.fastest, "V")
    return [
        seen,
        f"its voltage changes by up to {step} from one sample to the next, which the controller's "
        "voltage_rate has to allow.",
    ]


def _name(rival: Rival) -> str:
    """What to call an explanation in a sentence."""
    if not rival.effects:
        return "a mere refit"
    return " with ".join(name.replace("_", " ") for name in rival.effects)


def _remedy(one: Rival, other: Rival) -> str:
    """What would tell two explanations apart that no voltage does."""
    stages = [
        min((registry()[name].stage for name in rival.effects), key=lambda stage: stage.position)
        for rival in (one, other)
        if rival.effects
    ]
    if len(set(stages)) == 2:
        earlier = min(stages, key=lambda stage: stage.position)
        return f"measuring {BEHIND[earlier]} would tell"
    if any(stage is Stage.DRIVE for stage in stages):
        return "sampling faster would tell"
    return "only less noise or more voltage would tell"
