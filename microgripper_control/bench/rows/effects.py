"""The chain with effects on: whether they add what each adds alone, and what a step costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.growth import LINEAR, exponent
from microgripper_control.bench.row import LONGER, Curve, Effort, Line, Measured, Row
from microgripper_control.bench.timing import Contestant, Spread, take_turns
from microgripper_control.core.signals import ROWS, VOLTAGE, Array
from microgripper_control.effects.registry import registry
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.model import nominal_model

SAMPLES = 250  # few enough that the bus stays in the cache, as it does in `simulate`
DIVISIONS = (4, 8, 16, 32, 64)
GRID = 16  # steps a sample, on which the links that need no solve are compared


@dataclass(frozen=True)
class Subject:
    """The nominal chain with some effects; `steps` is what its mechanics take in a sample."""

    chain: Chain
    steps: int

    @classmethod
    def having(cls, effects: Sequence[str], divisions: int = 1) -> Subject:
        """With these effects at their nominal values."""
        model = nominal_model()
        forceless = model
        for name in effects:
            model = model.with_link(name)
            forceless = forceless if registry()[name].force else forceless.with_link(name)
        chain, without = (
            Chain(one, rig.SAMPLE_PERIOD, np.zeros(ROWS), divisions=divisions)
            for one in (model, forceless)
        )
        forces = len(model.links) - len(forceless.links)
        if not forces:
            return cls(chain, chain.steps)
        # How forces divide the mechanics' steps depends on the course that the links before leave:
        # only the chain knows it. Each force has a row beside, and all together one.
        return cls(chain, without.steps + chain.labour - without.labour - forces - 1)

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
    added = {name: step[name] - step["nominal"] for name in subjects}
    other, force = (np.sum([added[name] for name in group], axis=0) for group in (others, forces))
    whole = subjects["all"]
    lines = [
        _additive(f"{len(others)} effects at once, per internal step", added["others"], other),
        _additive(f"{len(forces)} forces at once, per substep", added["forces"], force),
        _additive(
            f"all {len(effects)} effects at once, per sample",
            whole.steps * added["all"],
            whole.steps * force + whole.chain.steps * other,
        ),
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
    spent = 1e6 * whole.steps * float(np.median(step["all"]))
    note = _NOTE.format(whole.chain.steps, whole.steps, spent)
    return Measured((*lines, line), (note,), (curve,))


def _additive(what: str, together: Array, one_by_one: Array) -> Line:
    return Line(
        f"added by {what}",
        "the sum of what each adds alone",
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
    "The first three lines say how far from linear in the links it is; what the nominal chain "
    "takes for an internal step is taken off everywhere. A force is solved inside the mechanics in "
    "substeps, few where the mass comes to rest, many where its path counts. The chain with "
    "everything on takes {} internal steps, which the mechanics divide into {} substeps, and "
    "{:.1f} us a sample: in the third line an effect alone counts for each of its own."
)


ROW = Row("effects", "the chain with effects on", measure)
