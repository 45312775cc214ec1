"""How cost grows with samples, effects and recordings, and what memory it takes."""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.growth import LINEAR, exponent
from microgripper_control.bench.long_bag import write_long_bag
from microgripper_control.bench.row import Curve, Effort, Line, Measured, Row, at_most
from microgripper_control.bench.timing import Contestant, Spread, take_turns
from microgripper_control.diagnosis.diagnose import candidate_names, diagnose
from microgripper_control.identification.fit import fit
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.read import read_recording

SAMPLES = (10_000, 100_000, 1_000_000, 10_000_000)
BESIDE = (2, 4, 8, 16)  # effects tried beside the planted one; each divides the sixteen others
RECORDINGS = (1, 3, 10, 30, 100)
SHORT = 1000  # samples of each of many recordings
TRIED = 6000  # samples of the recording that effects are tried on
PLANTED = "creep"
MOST_BYTES = 256  # a sample: no Python object is as small

Calls = Mapping[int, Contestant]  # by size


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    sizes = SAMPLES[: effort.among(len(SAMPLES), 3)]
    nominal = nominal_model()
    driven = {size: rig.voltage(size) for size in sizes}
    simulated = {
        n: Contestant(partial(simulate, nominal, u, rig.SAMPLE_PERIOD)) for n, u in driven.items()
    }
    bags = {size: effort.folder / f"{size}.mcap" for size in sizes}
    for size, bag in bags.items():
        write_long_bag(bag, size)
    read = {size: Contestant(partial(read_recording, bag)) for size, bag in bags.items()}
    _touch(MOST_BYTES * sizes[-1])
    found = [
        _growth(effort, "simulating the nominal chain", "samples", simulated),
        _growth(effort, "reading an MCAP", "samples", read),
        _growth(effort, "diagnosis by candidate effects", "effects", _diagnoses()),
        _growth(effort, "identification by recordings", "recordings", _fits()),
    ]
    memory = [
        _memory("simulating, at its peak", simulated),
        _memory("reading an MCAP, at its peak", read),
    ]
    notes = (
        "Exponents are those between the two largest sizes, where overheads no longer hide the "
        "growth. Each diagnosis and each fit starts from a model 10 % off. The recordings have "
        f"{SHORT} samples, each with an initial state of its own. Effects are tried on one of "
        f"{TRIED} samples; one costs a hundred times what another does, so that a diagnosis by "
        "fewer than all is the mean over sets that between them have each effect once. "
        f"{MOST_BYTES * sizes[-1] / 1e9:.3g} GB of memory were written to before: on a virtual "
        "machine that takes several times as long for the first time, as its host gives it out.",
    )
    lines = [line for line, _ in found] + memory
    return Measured(tuple(lines), notes, tuple(curve for _, curve in found))


def _touch(size: int) -> None:
    """Write to so many bytes once."""
    np.ones(size, np.uint8)


def _growth(effort: Effort, name: str, of: str, calls: Calls) -> tuple[Line, Curve]:
    """The time of a call by its size."""
    effort.progress(f"growth: {name}")
    contestants = {str(size): contestant for size, contestant in calls.items()}
    times = take_turns(contestants, effort.among(3, 1))
    costs = np.array([times.rounds[name] for name in contestants])
    sizes = tuple(float(size) for size in calls)
    what = f"{name}, {sizes[0]:g} to {sizes[-1]:g} {of}"
    last = exponent(sizes[-2:], costs[-2:])
    line = Line(what, f"time ~ size^p, from {sizes[-2]:g} on", last, "p", LINEAR)
    medians = tuple(float(cost) for cost in np.median(costs, axis=1))
    return line, Curve(name, of, sizes, medians, "s")


def _diagnoses() -> Calls:
    """A diagnosis by how many effects it may try, the planted one among them."""
    planted = nominal_model().with_link(PLANTED)
    recording = rig.recording(planted, TRIED)
    believed = rig.mistuned(nominal_model())
    others = [name for name in candidate_names() if name != PLANTED]

    def tried(sets: Sequence[Sequence[str]]) -> None:
        for beside in sets:
            left_out = [name for name in others if name not in beside]
            diagnose(believed, [recording], jobs=1, without=left_out)

    by_size = {}
    for count in BESIDE:
        parts = len(others) // count
        sets = [others[part::parts] for part in range(parts)]
        by_size[1 + count] = Contestant(partial(tried, sets), work=parts)
    return by_size


def _fits() -> Calls:
    """A fit by how many recordings it is given."""
    model = nominal_model()
    believed = rig.mistuned(model)
    recordings = [
        rig.recording(model, SHORT, seed, pace=1.0 + 0.03 * seed) for seed in range(RECORDINGS[-1])
    ]
    return {count: Contestant(partial(fit, believed, recordings[:count])) for count in RECORDINGS}


def _memory(what: str, calls: Calls) -> Line:
    """The most that was allocated at a time, of the largest size, in bytes per sample."""
    size = max(calls)
    tracemalloc.start()
    calls[size].call()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return Line(
        f"{what}, {size:g} samples",
        "",
        Spread.single(peak / size),
        "B a sample",
        at_most(MOST_BYTES),
    )


ROW = Row("growth", "how cost grows", measure)
