"""The chapters of the report on the paper: what each says, its tables and its figures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.identification import GAIN
from microgripper_control.paper.reproduction import Reproduction
from microgripper_control.paper.stiffness import SCATTER
from microgripper_control.report import paper_control_figures as control_figures
from microgripper_control.report import paper_figures as figures


@dataclass(frozen=True)
class Drawing:
    """A figure: the name of its PNG without the suffix, what it shows, and how it is drawn."""

    name: str
    caption: str
    draw: Callable[[Path], None]


@dataclass(frozen=True)
class Chapter:
    """One section of the paper."""

    title: str
    text: str
    rows: Sequence[Row]
    tables: Sequence[Table] = ()
    drawings: Sequence[Drawing] = ()


CHAPTERS = 8  # that `chapters` returns, for a progress bar


def chapters(r: Reproduction) -> list[Chapter]:
    """All chapters in the order of the paper."""
    return [
        _model(r),
        _stiffness(r),
        _identification(r),
        _inverse(r),
        _linearised(r),
        _pid(r),
        _open_loop(r),
        _headline(r),
    ]


def _model(r: Reproduction) -> Chapter:
    return Chapter(
        "Section 3: the Bouc-Wen model, equations (1) to (4)",
        "What Table 1 means before any experiment. The paper gives none of these values; they "
        "follow from its parameters.",
        r.behaviour.rows(),
        [r.behaviour.table()],
        [
            Drawing(
                "behaviour",
                "Left: classes of the Bouc-Wen operator over beta and gamma, and the widest drive "
                "range in which a settled cycle is monotone. Right: settled cycles of Table 1.",
                partial(figures.draw_behaviour, r.behaviour),
            )
        ],
    )


def _stiffness(r: Reproduction) -> Chapter:
    return Chapter(
        "Section 4: stiffness of the flexure, fig. 4",
        "The COMSOL model is not available. A linear elastic stand-in with the printed stiffness "
        f"and a scatter of {100.0 * SCATTER:g} % takes its place, so this checks the regression "
        "and not the flexure. The command microgripper stiffness does the same for measured data.",
        r.stiffness.rows(),
        drawings=[
            Drawing(
                "fig04_stiffness",
                "Fig. 4: force and displacement of the stand-in, and the regression with its 95 % "
                "interval.",
                partial(figures.draw_stiffness, r.stiffness),
            )
        ],
    )


def _identification(r: Reproduction) -> Chapter:
    shares = r.identification.paper.half_intervals()
    gain, others = shares.pop(GAIN), max(shares.values())
    return Chapter(
        "Section 5: identification, Table 1, fig. 7 and 8",
        "Simplex, then trust-region reflective least squares, on a simulated 0 to 160 V "
        "experiment, from a start that knows nothing of Table 1. The paper's K is d k/(k + k_s) "
        "of its values. Through the 1 µm sensor one recording of five cycles fixes K within "
        f"±{gain:.1f} %, but alpha, beta and gamma only within ±{others:.0f} %: Table 1 prints "
        "more digits of them than such a sensor gives.",
        r.identification.rows(),
        [r.identification.table()],
        [
            Drawing(
                "fig07_time_response",
                "Fig. 7: displacement of the simulated rig, read with the 1 µm sensor, and of the "
                "model identified from it.",
                partial(figures.draw_identification, r.identification),
            ),
            Drawing(
                "fig08_loop",
                "Fig. 8: the hysteresis loop of the identified model.",
                partial(figures.draw_loop, r.identification),
            ),
        ],
    )


def _inverse(r: Reproduction) -> Chapter:
    resonance = 2.0 * math.pi / r.linear_plant.with_flexure.fast_pole.imag
    return Chapter(
        "Section 6: the inverse model, equations (5) and (6), Table 2, fig. 9 and 10",
        "As in the paper, alpha, beta and gamma of the inverse model are fitted from displacement "
        "to voltage, apart from the forward model's. Table 2 itself needs the paper's data and is "
        "compared with, not reproduced. As a compensator at 1 kHz the exact discrete inverse is "
        "the better one: equation (6), stepped explicitly, cancels the hysteresis one tick late. "
        "Where the sampling resolves the mechanics, equation (6) is the better one, because the "
        "exact inverse knows neither inertia nor damping.",
        r.inverse.rows(),
        r.inverse.tables(),
        [
            Drawing(
                "fig10_inverse",
                "Fig. 10: the voltage applied, and the one the inverse model finds from the "
                "displacement that the 1 µm sensor read.",
                partial(figures.draw_inverse, r.inverse),
            ),
            Drawing(
                "compensators",
                "Error of the two compensators over the sample period. Steps of some ten "
                f"microseconds excite the resonance, whose period is {1e6 * resonance:.0f} µs; the "
                "exact inverse is best where half a step makes up for the lag of the damper.",
                partial(figures.draw_compensators, r.inverse),
            ),
        ],
    )


def _linearised(r: Reproduction) -> Chapter:
    return Chapter(
        "Section 7: linearisation, equations (7) to (15), fig. 12 to 14",
        "k1 and k2 by simplex on the hysteretic variable; then state space, transfer function, "
        "zero and poles. k1 comes out near the printed value whatever the course. k2 is in "
        "proportion to the drive's frequency, which the paper does not give, and the numbers of "
        "(15) do not follow from its own k1 and k2: see the slips.",
        [*r.linearised.rows(), *r.linear_plant.rows()],
        [*r.linearised.tables(), *r.linear_plant.tables()],
        [
            Drawing(
                "fig12_13_linear_hysteresis",
                "Fig. 12 and 13: the hysteretic variable and its linear equivalent, over time and "
                "over the voltage.",
                partial(control_figures.draw_linear_hysteresis, r.linearised),
            ),
            Drawing(
                "fig14_linear_displacement",
                "Fig. 14: displacement of the nonlinear and the linearised model.",
                partial(control_figures.draw_linear_displacement, r.linearised),
            ),
            Drawing(
                "k2_over_frequency",
                "k1 and k2 fitted at different drive frequencies. The dot marks the frequency "
                "that would give the printed k2.",
                partial(control_figures.draw_frequency, r.linearised),
            ),
        ],
    )


def _pid(r: Reproduction) -> Chapter:
    return Chapter(
        "Section 8: PID, equation (16), fig. 15",
        "Ziegler and Nichols' rules on the linear model, then gains optimised for the least "
        "tracking error on the nonlinear plant. The paper prints no gains to compare with.",
        r.pid.rows(),
        [r.pid.table()],
        [
            Drawing(
                "fig15_pid",
                "Fig. 15: the nonlinear plant under PID alone, with the Ziegler-Nichols and with "
                "the optimised gains.",
                partial(control_figures.draw_pid, r.pid),
            )
        ],
    )


def _open_loop(r: Reproduction) -> Chapter:
    return Chapter(
        "Section 9: the linearised model in open loop, fig. 16 and 17",
        "The voltage for a required displacement from the linearised model, applied to the "
        "nonlinear plant. The slope is near one, as the paper says, at the one frequency that k2 "
        "was fitted at.",
        r.open_loop.rows(),
        [r.open_loop.table()],
        [
            Drawing(
                "fig16_17_open_loop",
                "Fig. 16: voltage for a required displacement. Fig. 17, drawn as a difference: "
                "resulting less required displacement.",
                partial(control_figures.draw_open_loop, r.open_loop),
            )
        ],
    )


def _headline(r: Reproduction) -> Chapter:
    return Chapter(
        'Abstract and section 10: "less than 5 %"',
        "Tracking errors of the four laws. With the 1 µm sensor most of what remains is the "
        "resolution itself: half a step of it comes close to the paper's 5 % for any loop.",
        r.headline.rows(),
        r.headline.tables(),
        [
            Drawing(
                "headline",
                "Largest tracking error at 1 Hz.",
                partial(control_figures.draw_headline, r.headline),
            ),
            Drawing(
                "tracking",
                "Errors over time at 1 Hz, from rest. Each law on the plant that is worst for it.",
                partial(control_figures.draw_tracking, r.headline),
            ),
        ],
    )
