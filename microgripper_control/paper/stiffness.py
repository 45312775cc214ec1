"""Section 4, fig. 3 and 4: the flexure's stiffness from force and displacement.

The paper's data come from a COMSOL model of the flexure, which is not available. What stands in is
a linear elastic flexure of the printed stiffness with a little scatter: it checks the regression,
and says nothing of the flexure. `identification.stiffness.fit_stiffness` does the same for data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.identification.stiffness import Stiffness, fit_stiffness
from microgripper_control.paper.agreement import Kind, Row
from microgripper_control.paper.printed import LARGEST_FORCE, STIFFNESS

POINTS = 25
SCATTER = 0.005  # standard deviation, share of the largest displacement
SEED = 120


@dataclass(frozen=True)
class StiffnessResult:
    """The stand-in's data, N and m, and the line through them."""

    force: Array
    displacement: Array
    fit: Stiffness

    def rows(self) -> list[Row]:
        """The stiffness against the printed one."""
        low, high = self.fit.interval
        return [
            Row(
                "4, fig. 4",
                "flexure stiffness k_s",
                "N/m",
                self.fit.value,
                STIFFNESS,
                "of a stand-in with that stiffness planted, as the COMSOL model is not available: "
                f"checks the regression alone; 95 % interval {low:.4g} .. {high:.4g}",
                kind=Kind.PLANTED,
            )
        ]


def reproduce_stiffness() -> StiffnessResult:
    """Make the stand-in's data and fit them."""
    force = np.linspace(0.0, LARGEST_FORCE, POINTS)
    scatter = SCATTER * LARGEST_FORCE * np.random.default_rng(SEED).standard_normal(POINTS)
    displacement = (force + scatter) / STIFFNESS
    return StiffnessResult(force, displacement, fit_stiffness(force, displacement))
