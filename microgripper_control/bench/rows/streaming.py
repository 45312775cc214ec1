"""One streaming step from Python: what a node pays for a tick of the plant."""

from __future__ import annotations

from microgripper_control.bench import rig
from microgripper_control.bench.row import LONGER, Effort, Line, Measured, Row, at_most
from microgripper_control.bench.timing import Contestant, take_turns
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.rig import Rig
from microgripper_control.plant.simulate import Plant

STEPS = 1000
MOST = at_most(15e-6)  # s


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    voltage = rig.voltage(STEPS).tolist()
    nominal, full = nominal_model(), nominal_model()
    for name, link in registry().items():
        full = full if link.nominal else full.with_link(name)

    def stream(model: Model) -> Contestant:
        plant = Plant(model, rig.SAMPLE_PERIOD)

        def run() -> None:
            for volts in voltage:
                plant.read()
                plant.write(volts)

        return Contestant(run, STEPS)

    def tick(model: Model) -> Contestant:
        simulated = Rig(model, rig.SAMPLE_PERIOD)

        def run() -> None:
            for volts in voltage:
                simulated.command(volts)
                simulated.tick()

        return Contestant(run, STEPS)

    def call() -> None:
        for volts in voltage:
            _nothing(volts)

    contestants = {
        "nominal chain, read and write": stream(nominal),
        "the node's tick: command, read, velocity, write": tick(nominal),
        "chain with all effects, read and write": stream(full),
    }
    times = take_turns({**contestants, "call": Contestant(call, STEPS)}, effort.rounds)
    lines = []
    for name in contestants:
        against = "an empty Python call"
        goal = MOST if name.startswith("nominal") else None
        lines.append(Line(name, "", times.of(name), "s", goal))
        ratio = times.ratio(name, "call")
        ours, theirs = times.of(name).median, times.of("call").median
        lines.append(Line(name, against, ratio, LONGER, None, ours, theirs))
    return Measured(tuple(lines))


def _nothing(volts: float) -> None:
    """What is measured against."""


ROW = Row("streaming", "one streaming step from Python", measure)
