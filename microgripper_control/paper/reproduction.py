"""Every section of the paper, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from microgripper_control.control.identified import Identified
from microgripper_control.paper.agreement import Row
from microgripper_control.paper.behaviour import BehaviourResult, reproduce_behaviour
from microgripper_control.paper.headline import HeadlineResult, reproduce_headline
from microgripper_control.paper.identification import (
    IdentificationResult,
    reproduce_identification,
)
from microgripper_control.paper.inverse import InverseResult, reproduce_inverse
from microgripper_control.paper.linear_plant import LinearPlantResult, reproduce_linear_plant
from microgripper_control.paper.linearised import LinearisedResult, reproduce_linearised
from microgripper_control.paper.open_loop import OpenLoopResult, reproduce_open_loop
from microgripper_control.paper.pid import ROBUST, PidResult, reproduce_pid
from microgripper_control.paper.setpoint import common_reach, mismatched
from microgripper_control.paper.slips import found_slips
from microgripper_control.paper.stiffness import StiffnessResult, reproduce_stiffness
from microgripper_control.plant.model import nominal_model

STAGES = 20  # calls of `progress`, for a bar


@dataclass(frozen=True)
class Reproduction:
    """What came out, by section of the paper."""

    behaviour: BehaviourResult
    stiffness: StiffnessResult
    identification: IdentificationResult
    inverse: InverseResult
    linearised: LinearisedResult
    linear_plant: LinearPlantResult
    pid: PidResult
    open_loop: OpenLoopResult
    headline: HeadlineResult

    def rows(self) -> list[Row]:
        """The table of agreement, in the order of the paper."""
        parts = (
            self.behaviour,
            self.stiffness,
            self.identification,
            self.inverse,
            self.linearised,
            self.linear_plant,
            self.pid,
            self.open_loop,
            self.headline,
        )
        return [row for part in parts for row in part.rows()]

    def slips(self) -> list[str]:
        """What the paper prints that cannot be meant or cannot follow."""
        return found_slips(self.behaviour, self.inverse, self.linearised, self.linear_plant)


def reproduce(progress: Callable[[str], None] = lambda stage: None) -> Reproduction:
    """Recompute the paper from Table 1 and what else it states; seconds to a minute.

    `progress` is told each stage as it begins.
    """
    plant = nominal_model()
    progress("Table 1")
    behaviour = reproduce_behaviour(plant)
    stiffness = reproduce_stiffness()
    reach = common_reach([plant, *mismatched(plant)])
    identification = reproduce_identification(plant, progress)
    inverse = reproduce_inverse(plant, reach, progress)
    progress("linearisation")
    linearised = reproduce_linearised(plant)
    linear = linearised.fit.found
    linear_plant = reproduce_linear_plant(Identified.of(plant), linear)
    open_loop = reproduce_open_loop(plant, linear, reach)
    pid = reproduce_pid(plant, linear, reach, progress)
    seen = Identified.of(identification.paper.fit.model)
    gains = pid.sets[ROBUST].gains
    headline = reproduce_headline(plant, gains, seen, reach, progress)
    return Reproduction(
        behaviour,
        stiffness,
        identification,
        inverse,
        linearised,
        linear_plant,
        pid,
        open_loop,
        headline,
    )
