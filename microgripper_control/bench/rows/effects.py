"""The chain with effects on: whether they cost what they cost one by one, and what a step costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.growth import LINEAR, exponent
from microgripper_control.bench.row import LONGER, Curve, Effort, Line, Measured, Row
from microgripper_control.bench.timing import Contestant, Spread, take_turns
from microgripper_control.core.signals import LEVELS, ROWS, VOLTAGE, Array
from microgripper_control.effects.base import Load
from microgripper_control.effects.registry import registry
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.model import nominal_model

SAMPLES = 250  # few enough that the bus stays in the cache, as it does in `simulate`
DIVISIONS = (4, 8, 16, 32, 64)
GRID = 16  # steps a sample, on which the links that need no solve are compared


@dataclass(frozen=True)
class Subject:
    """The nominal chain with some effects; `steps` is what it steps through in a sample."""

    chain: Chain
    steps: int

    @classmethod
    def having(cls, effects: Sequence[str], divisions: int = 1) -> Subject:
        """With these effects at their nominal values."""
        model = nominal_model()
        for name in effects:
            model = model.with_link(name)
        chain = Chain(model, rig.SAMPLE_PERIOD, np.zeros(ROWS), divisions=divisions)
        mechanics = registry()["second_order"]
        loads: list[Load] = [(x.force, model.values(x.name)) for x in model.links if x.force]
        if not loads or mechanics.solver is None:
            return cls(chain, chain.steps)
        values = model.values(mechanics.name)
        solve = mechanics.solver.prepare(values, chain.timing, np.zeros(LEVELS), loads)
        return cls(chain, len(solve.coefficients) - 1 - len(loads))

    def contestant(self) -> Contestant:
        """Runs over `SAMPLES` samples; timed per step."""
        # It moves in each step, as it does behind an amplifier: links may skip what is held.
        samples = np.arange(SAMPLES * self.chain.steps) / self.chain.steps
        voltage = np.interp(samples, np.arange(SAMPLES), rig.voltage(SAMPLES))
        bus = np.zeros((ROWS, len(voltage)))

        def run() -> None:
            bus[VOLTAGE] = voltage  # links of the drive write over it
            self.chain.advance(bus)

        return Contestant(run, SAMPLES * self.steps)


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    effects = [name for name, link in registry().items() if not (link.nominal or link.sampled)]
    forces = [name for name in effects if registry()[name].force]
    others = [name for name in effects if name not in forces]
    subjects = {name: Subject.having([name], GRID) for name in others}
    subjects |= {name: Subject.having([name]) for name in forces}
    subjects |= {
        "others": Subject.having(others, GRID),
        "forces": Subject.having(forces),
        "all": Subject.having(effects),
        "nominal": Subject.having([], GRID),
    }
    times = take_turns({n: subject.contestant() for n, subject in subjects.items()}, effort.rounds)
    step = times.rounds
    one_by_one = step["nominal"] + sum(step[name] - step["nominal"] for name in others)
    alone = np.sum([step[name] for name in forces], axis=0)
    lines = [
        _additive(f"{len(others)} effects at once, per internal step", step["others"], one_by_one),
        _additive(f"{len(forces)} forces at once, per substep", step["forces"], alone),
    ]
    lines += [
        Line(
            f"{name}, per internal step ({subjects[name].steps} a sample)",
            "nominal chain, per internal step",
            Spread.of(step[name] / step["nominal"]),
            LONGER,
            None,
            float(np.median(step[name])),
            float(np.median(step["nominal"])),
        )
        for name in (*forces, "all")
    ]
    line, curve = _by_steps(effort)
    return Measured((*lines, line), (_NOTE.format(*_whole(subjects, step)),), (curve,))


def _additive(what: str, together: Array, one_by_one: Array) -> Line:
    return Line(
        what,
        "the sum of one by one",
        Spread.of(together / one_by_one),
        LONGER,
        LINEAR,
        float(np.median(together)),
        float(np.median(one_by_one)),
    )


def _by_steps(effort: Effort) -> tuple[Line, Curve]:
    """How the nominal chain's cost grows with its internal steps."""
    subjects = {str(division): Subject.having([], division) for division in DIVISIONS}
    times = take_turns({n: subject.contestant() for n, subject in subjects.items()}, effort.rounds)
    costs = np.array([times.rounds[str(d)] * d for d in DIVISIONS])
    what = f"nominal chain, {DIVISIONS[0]} to {DIVISIONS[-1]} internal steps a sample"
    line = Line(what, "cost ~ steps^p", exponent(DIVISIONS, costs), "p", LINEAR)
    medians = tuple(float(cost) for cost in np.median(costs, axis=1))
    return line, Curve("nominal chain", "internal steps a sample", DIVISIONS, medians, "s a sample")


_NOTE = (
    "The first two lines say how far from linear in the links it is. A force is solved "
    "inside the mechanics in substeps, few where the mass comes to rest, many where its path "
    "counts. The chain with everything on takes {:.0f} substeps and {:.1f} us a sample."
)


def _whole(subjects: Mapping[str, Subject], step: Mapping[str, Array]) -> tuple[float, float]:
    steps = subjects["all"].steps
    return steps, 1e6 * steps * float(np.median(step["all"]))


ROW = Row("effects", "the chain with effects on", measure)
