"""Cases with answers and truths made by hand, of which the score is known."""

from __future__ import annotations

from typing import Any

from microgripper_control.effects.registry import registry
from microgripper_control.examination.asking import ANSWERED, LATE
from microgripper_control.examination.beside.compare import METHODS
from microgripper_control.examination.marking import Marked, mark
from microgripper_control.examination.plan import Planned
from microgripper_control.examination.record import Beside, Record
from microgripper_control.examination.sealed import Span

NM = 1e-9
NOISE = 10.0 * NM
VERDICTS = ("none", "parameters", "unknown")
CONTACT = Span("displacement_m", 10e-6, 20e-6)


def planned(effects: tuple[str, ...], question: str = "blind", number: int = 1) -> Planned:
    return Planned(number, question, effects, "a", "medium", "mixed", 7000 + number)


def truth(
    effects: tuple[str, ...],
    question: str = "blind",
    ratio: float = 5.0,
    seen: bool = True,
    where: tuple[Span, ...] = (),
) -> dict[str, Any]:
    blank = effects[0] in VERDICTS
    known = question != "never"
    causes = [
        {
            "effect": name,
            "stage": registry()[name].stage.value if known else "drive",
            "ratio": ratio - index,
            "seen": seen,
            "where": [{"axis": s.axis, "low": s.low, "high": s.high} for s in where],
        }
        for index, name in enumerate(() if blank else effects)
    ]
    verdict = effects[0] if blank else "effects" if seen and known else "unknown"
    return {
        "question": question,
        "effects": list(effects),
        "form": "a",
        "excitation": "mixed",
        "verdict": verdict if seen else "parameters",
        "causes": causes,
        "ratio": ratio,
        "noise_m": NOISE,
        "errors_m": {
            "nominal": {"heldout": 2.0 * ratio * NOISE},
            "refit": {"heldout": ratio * NOISE},
            "oracle": {"heldout": NOISE},
        },
    }


def diagnosis(
    said: tuple[str, ...],
    probability: float = 0.9,
    groups: tuple[tuple[str, ...], ...] = (),
    refit: float = 50.0 * NM,
    augmented: float = 10.0 * NM,
    where: tuple[Span, ...] = (),
) -> dict[str, Any]:
    """An answer: effects, or one of the verdicts; the rest of the probability is unknown's."""
    effects = [name for name in said if name not in VERDICTS]
    other = "unknown" if said[0] != "unknown" else "none"
    given = {said[0]: probability, other: 1.0 - probability}
    stages = dict.fromkeys(("drive", "material", "mechanics", "transmission", "sensor"), 0.0)
    entries = []
    for name in dict.fromkeys([*said, other]):
        stage = None if name in VERDICTS else registry()[name].stage.value
        if stage:
            stages[stage] += given.get(name, 0.0)
        entries.append(
            {
                "effect": name,
                "stage": stage,
                "probability": given.get(name, 0.0),
                "present": probability,
                "heldout_rmse_m": augmented,
            }
        )
    return {
        "verdict": "effects" if effects else said[0],
        "effects": effects,
        "candidates": entries,
        "stages": stages,
        "gap": {
            "nominal_rmse_m": 2.0 * refit,
            "refit_rmse_m": refit,
            "augmented_rmse_m": augmented,
            "noise_floor_m": NOISE,
            "free_form_fraction": 0.5,
        },
        "where": [{"axis": s.axis, "low": s.low, "high": s.high} for s in where],
        "ambiguous": [list(group) for group in groups],
    }


def record(
    case: Planned,
    answer: dict[str, Any] | None,
    rivals: dict[str, float | None] | None = None,
    beside: tuple[str | None, str | None] = ("creep", "material"),
) -> Record:
    others = {name: Beside(*beside, 30.0 * NM, 5.0) for name in METHODS[:-1]}
    others[METHODS[-1]] = Beside(None, None, 20.0 * NM, 1.0)
    outcome, why = (ANSWERED, "") if answer else (LATE, "no answer within 300 s")
    seconds = {
        "making": 1.0,
        "diagnosing": 21.0,
        "diagnosing_busy": 20.0,
        "beside": 3.0,
        "rivals": 0.0,
    }
    return Record(case, outcome, why, seconds, answer, others, rivals or {})


def marked(
    effects: tuple[str, ...],
    answer: dict[str, Any] | None,
    question: str = "blind",
    rivals: dict[str, float | None] | None = None,
    number: int = 1,
    ratio: float = 5.0,
    seen: bool = True,
    where: tuple[Span, ...] = (),
) -> Marked:
    made = record(planned(effects, question, number), answer, rivals)
    return mark(made, truth(effects, question, ratio, seen, where))
