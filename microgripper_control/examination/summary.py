"""The score as plain data: `validation.json`, version 1."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from microgripper_control.examination.calibration import Reliability
from microgripper_control.examination.marking import Marked, probability_of
from microgripper_control.examination.places import Places
from microgripper_control.examination.plan import Extent
from microgripper_control.examination.score import Effect, Foreign, Score
from microgripper_control.examination.shares import Middle, Share
from microgripper_control.examination.shrinking import errors_of
from microgripper_control.examination.sources import sources
from microgripper_control.examination.targets import Target, targets

SCHEMA = "microgripper-validation/1"


def as_json(score: Score, extent: Extent) -> dict[str, Any]:
    """The score for other programs, SI units throughout; what cannot be told is null."""
    return {
        "schema": SCHEMA,
        "code": sources(),
        **asdict(extent),
        "seed_used_in_development": extent.used,
        "cases_done": len(score.cases),
        "targets": [_target(target) for target in targets(score)],
        "top_1": {name: _share(share) for name, share in score.top.items()},
        "top_1_groups_aside": {name: _share(share) for name, share in score.first.items()},
        "top_1_by_form": {name: _share(share) for name, share in score.forms.items()},
        "stage": _share(score.stage),
        "right_and_nothing_besides": _share(score.alone),
        "groups_whose_oracles_agree": _share(score.groups),
        "blanks": {name: _share(share) for name, share in score.blanks.items()},
        "false_alarms": _share(score.false_alarms),
        "unseen_and_nothing_else_claimed": _share(score.unseen),
        "unknown": _share(score.unknown),
        "foreign": {name: _foreign(foreign) for name, foreign in score.foreign.items()},
        "pairs_both_named": _share(score.pairs),
        "pairs_both_and_nothing_besides": _share(score.pairs_alone),
        "pairs_one_of_them_first": _share(score.pairs_first),
        "calibration": {
            "probability": _reliability(score.probability),
            "present": _reliability(score.present),
            "present_claimed": _reliability(score.present_claimed),
        },
        "where": _places(score.places),
        "errors_over_noise": {name: _middle(middle) for name, middle in score.errors.items()},
        "gap_closed": _middle(score.closed),
        "seconds": _middle(score.seconds) | {"longest": _number(score.longest)},
        "effects": [_effect(effect) for effect in score.effects],
        "matrix": {
            "asked": list(score.matrix.asked),
            "said": list(score.matrix.said),
            "counts": [list(row) for row in score.matrix.counts],
        },
        "confusions": [
            asdict(one) | {"cases": list(one.cases), "reasons": dict(one.reasons)}
            for one in score.confusions
        ],
        "methods": [
            {
                "name": method.name,
                "top_1_groups_aside": _share(method.top),
                "stage": _share(method.stage),
                "false_alarms": _share(method.false_alarms),
                "unknown": _share(method.unknown),
                "gap_closed": _middle(method.closed),
                "seconds": _middle(method.seconds),
            }
            for method in score.methods
        ],
        "failures": [
            {"case": name, "outcome": outcome, "why": why} for name, outcome, why in score.failures
        ],
        "cases": [_case(case) for case in score.cases],
    }


def _case(case: Marked) -> dict[str, Any]:
    return {
        **case.record.planned.plain(),
        "name": case.record.planned.name,
        "strength_reached": case.sealed.strength,
        "ratio": case.sealed.ratio,
        "asked": case.asked,
        "said": case.said,
        "probability": probability_of(case.diagnosis) if case.diagnosis else None,
        "right": case.right,
        "stage_right": case.stage_right,
        "outcome": case.record.outcome,
        "seconds": dict(case.record.seconds),
        "errors": asdict(errors_of(case)),
        "rivals": dict(case.record.rivals),
        "beside": {name: asdict(one) for name, one in case.record.beside.items()},
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _share(share: Share) -> dict[str, Any]:
    low, high = share.interval
    return {
        "value": _number(share.value),
        "low": _number(low),
        "high": _number(high),
        "right": share.right,
        "of": share.of,
    }


def _middle(middle: Middle) -> dict[str, Any]:
    return {
        "median": _number(middle.value),
        "low": _number(middle.low),
        "high": _number(middle.high),
        "of": middle.of,
    }


def _reliability(found: Reliability) -> dict[str, Any]:
    bins = [
        {"low": one.low, "high": one.high, "mean": one.mean, "came_true": _share(one.share)}
        for one in found.bins
    ]
    low, high = found.by_chance
    by_chance = {"low": _number(low), "high": _number(high)}
    return {"error": _number(found.error), "by_chance": by_chance, "of": found.of, "bins": bins}


def _places(found: Places) -> dict[str, Any]:
    return {
        "precision": _share(found.precision),
        "recall": _share(found.recall),
        "on_other_axes": found.elsewhere,
    }


def _effect(effect: Effect) -> dict[str, Any]:
    return {
        "effect": effect.name,
        "top_1": {name: _share(share) for name, share in effect.top.items()},
        "stage": _share(effect.stage),
        "where": _places(effect.places),
    }


def _foreign(foreign: Foreign) -> dict[str, Any]:
    return {
        "unknown": _share(foreign.unknown),
        "equivalent_stand_in": _share(foreign.stands_in),
        "stage": _share(foreign.stage),
        "where": _places(foreign.places),
        "free_form_fraction": _middle(foreign.free_form),
    }


def _target(target: Target) -> dict[str, Any]:
    return {
        "name": target.name,
        "text": target.text,
        "value": _number(target.value),
        "low": _number(target.low),
        "high": _number(target.high),
        "of": target.of,
        "limit": target.limit,
        "at_most": target.at_most,
        "verdict": target.verdict,
    }
