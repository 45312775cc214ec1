"""Section 3, equations (1)-(4): what Table 1 means for the actuator, before any experiment.

The class of the Bouc-Wen operator, the drive ranges in which it makes sense, and the loop: stroke,
width, and what is left at 0 V. The paper reports none of it; it follows from its parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.control.identified import Identified
from microgripper_control.core.signals import Array
from microgripper_control.effects.bouc_wen_behaviour import Behaviour, behaviour
from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.experiment import drive, hysteresis
from microgripper_control.paper.printed import TABLE_2
from microgripper_control.plant.model import Model

CYCLES_TO_SETTLE = 20
RANGES = (160.0, 225.0, 300.0)  # V, of the loops that are drawn: safe, at the limit, beyond
SECTION = "3, Table 1"


@dataclass(frozen=True)
class Loop:
    """One settled cycle, up and down: voltage, V, and displacement, m."""

    voltage: Array
    displacement: Array


@dataclass(frozen=True)
class BehaviourResult:
    """Table 1 and Table 2 classified, and the loop of Table 1."""

    model: Model
    table_1: Behaviour
    table_2: Behaviour
    stroke: float  # m, first rise over the drive range
    first_width: float  # share of the first cycle's stroke
    settled_width: float  # share of the settled cycle's stroke
    left: tuple[float, float]  # m at 0 V, smallest and largest after the first cycles
    counter_motion: float  # m, of the displacement right after the first turn at full voltage
    loops: dict[float, Loop]

    def rows(self) -> list[Row]:
        """Found here; the paper prints none of it."""
        b = self.table_1
        high = self.model.voltage_range[1]
        return [
            Row(
                SECTION,
                "safe range, 0 V upwards",
                "V",
                b.safe_span,
                form=".1f",
                remark="in a settled cycle over more the displacement turns against the voltage",
            ),
            Row(SECTION, "safe range, to both sides", "V", b.safe_span / 2.0, form=".1f"),
            Row(
                SECTION,
                "safe first rise",
                "V",
                b.first_rise,
                form=".1f",
                remark="below the 160 V of the experiment: see the next line",
            ),
            Row(
                SECTION,
                f"motion against the voltage at the first turn, {high:g} V",
                "nm",
                1e9 * self.counter_motion,
                form=".2f",
                remark="far below the sensor's resolution",
            ),
            Row(SECTION, f"displacement at {high:g} V, first rise", "µm", 1e6 * self.stroke),
            Row(
                SECTION,
                "loop width, first cycle",
                "% of stroke",
                100.0 * self.first_width,
                form=".1f",
            ),
            Row(
                SECTION,
                "loop width, settled",
                "% of stroke",
                100.0 * self.settled_width,
                form=".1f",
            ),
            Row(
                SECTION,
                "left at 0 V after one cycle",
                "µm",
                1e6 * self.left[0],
                form=".2f",
                remark="setpoints below cannot be reached any more",
            ),
            Row(SECTION, "left at 0 V after many", "µm", 1e6 * self.left[1], form=".2f"),
        ]

    def table(self) -> Table:
        """The classes in words."""
        rows = [
            (name, found.kind.value, f"{found.safe_span:.1f} V", f"{0.5 * found.safe_span:.1f} V")
            for name, found in (("Table 1", self.table_1), ("Table 2", self.table_2))
        ]
        return Table(
            "Class of the Bouc-Wen operator",
            ("parameters", "class", "safe unipolar range", "safe bipolar range, ±"),
            rows,
            "beta + gamma < 0 in both: on rising voltage h grows exponentially. Within the drive "
            "range of the experiment the settled cycle behaves.",
            (0, 1),
        )


def settled_loop(model: Model, voltage_span: float, cycles: int = CYCLES_TO_SETTLE) -> Loop:
    """The last of some cycles over 0 .. `voltage_span`, V; equations (2) and (4) at rest."""
    wide = Model(model.name, (0.0, voltage_span), model.settings)
    voltage = drive(wide, "triangle", cycles)
    displacement = at_rest(model, voltage)
    period = (len(voltage) - 1) // cycles
    return Loop(voltage[-period - 1 :], displacement[-period - 1 :])


def at_rest(model: Model, voltage: Array) -> Array:
    """x = k/(k + k_s) (d u - h), m: equation (4) with the mechanics settled, h by (2)."""
    v = Identified.of(model)
    return v.compliance * (v.d * voltage - hysteresis(model, voltage))


def loop_width(loop: Loop) -> float:
    """Largest distance between the branches at one voltage, as a share of the stroke."""
    top = int(np.argmax(loop.voltage))
    up = np.interp(loop.voltage, loop.voltage[: top + 1], loop.displacement[: top + 1])
    apart = np.abs(loop.displacement - up)[top:]
    return float(apart.max() / np.ptp(loop.displacement[: top + 1]))


def safe_spans(model: Model, betas: Array, gammas: Array) -> Array:
    """The safe drive range, V, of the model with other beta and gamma (1/V), shape (b, g)."""
    values = model.values("bouc_wen")
    return np.array(
        [
            [behaviour({**values, "beta": beta, "gamma": gamma}).safe_span for gamma in gammas]
            for beta in betas
        ]
    )


def reproduce_behaviour(model: Model) -> BehaviourResult:
    """Classify Table 1 and Table 2 and follow the loop of `model`."""
    values = model.values("bouc_wen")
    voltage = drive(model, "triangle", CYCLES_TO_SETTLE)
    displacement = at_rest(model, voltage)
    period = (len(voltage) - 1) // CYCLES_TO_SETTLE
    top = period // 2
    first = Loop(voltage[: period + 1], displacement[: period + 1])
    left = displacement[period::period]
    return BehaviourResult(
        model=model,
        table_1=behaviour(values),
        table_2=behaviour({**values, **TABLE_2}),
        stroke=float(displacement[top]),
        first_width=loop_width(first),
        settled_width=loop_width(settled_loop(model, float(voltage.max()))),
        left=(float(left.min()), float(left.max())),
        counter_motion=_counter_motion(model),
        loops={span: settled_loop(model, span) for span in RANGES},
    )


def _counter_motion(model: Model) -> float:
    """How far the displacement still rises after the first turn at full voltage, m."""
    high = model.voltage_range[1]
    fine = np.concatenate([[high], high - np.linspace(0.0, 0.1 * high, 1601)])
    displacement = at_rest(model, fine)
    return float(displacement.max() - displacement[0])
