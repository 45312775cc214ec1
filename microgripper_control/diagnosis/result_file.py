"""A diagnosis as `diagnosis.json`, version 1."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from microgripper_control.core.files import written_whole
from microgripper_control.diagnosis.findings import (
    Candidate,
    Diagnosis,
    Gap,
    NextExperiment,
    Range,
)
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Setting

SCHEMA = "microgripper-diagnosis/1"
REPORT, RESULT, MODEL = "report.html", "diagnosis.json", "model.yaml"  # in a diagnosis's folder
NEXT_EXPERIMENT = "next_experiment.csv"


def as_json(found: Diagnosis, folder: Path) -> dict[str, Any]:
    """The diagnosis for other programs, SI units throughout; `folder` is where its files lie."""
    return {
        "schema": SCHEMA,
        "verdict": found.verdict,
        "sentence": found.sentence,
        "effects": list(found.effects),
        "candidates": [_candidate(candidate) for candidate in found.candidates],
        "stages": dict(found.stages),
        "gap": _gap(found.gap),
        "where": [_range(one) for one in found.where],
        "ambiguous": [list(group) for group in found.ambiguous],
        "shares": dict(found.shares),
        "next_experiment": _experiment(found.next_experiment, folder),
        "warnings": list(found.warnings),
    }


def write_result(found: Diagnosis, folder: Path) -> None:
    """Write `diagnosis.json` and the next experiment's voltage into a folder."""
    # A voltage that answered another question must not be taken for this one's.
    (folder / NEXT_EXPERIMENT).unlink(missing_ok=True)
    if found.next_experiment:
        _write_voltage(found.next_experiment, folder / NEXT_EXPERIMENT)
    with written_whole(folder / RESULT) as file:
        json.dump(as_json(found, folder), file, indent=2, allow_nan=False)
        file.write("\n")


def _range(found: Range) -> dict[str, Any]:
    own = {"recording": found.recording} if found.recording else {}
    return {
        "axis": found.axis,
        "low": found.low,
        "high": found.high,
        "share_of_gap": found.share_of_gap,
        **own,
    }


def _candidate(candidate: Candidate) -> dict[str, Any]:
    return {
        "effect": candidate.effect,
        "stage": candidate.stage,
        "probability": candidate.probability,
        "present": candidate.present,
        "heldout_rmse_m": candidate.rmse,
        "parameters": _parameters(candidate.effect, candidate.parameters),
        "share": candidate.share,
        "signatures": [
            {"agrees": s.agrees, "statement": s.statement} for s in candidate.signatures
        ],
        "note": candidate.note,
    }


def _parameters(effect: str, settings: Mapping[str, Setting]) -> dict[str, Any]:
    plain = {}
    for name, setting in settings.items():
        low, high = setting.ends
        unit = registry()[effect].parameter(name).unit
        plain[name] = {"value": setting.value, "unit": unit, "low": low, "high": high}
    return plain


def _gap(gap: Gap) -> dict[str, Any]:
    return {
        "nominal_rmse_m": gap.nominal,
        "refit_rmse_m": gap.refit,
        "augmented_rmse_m": gap.augmented,
        "noise_floor_m": gap.noise_floor,
        "closed_fraction": gap.closed,
        "closed_low": gap.closed_low,
        "closed_high": gap.closed_high,
        "free_form_fraction": gap.free_form,
        "driven_fraction": gap.driven,
        "on": "heldout",
        "heldout": "recordings" if gap.separate else "blocks",
    }


def _experiment(experiment: NextExperiment | None, folder: Path) -> dict[str, Any] | None:
    if experiment is None:
        return None
    return {
        "why": experiment.why,
        "separates": list(experiment.separates),
        "voltage_csv": str(folder / NEXT_EXPERIMENT),
    }


def _write_voltage(experiment: NextExperiment, path: Path) -> None:
    with written_whole(path) as file:
        file.write("time_s,voltage_V\n")
        for index, volts in enumerate(experiment.voltage):
            file.write(f"{index * experiment.sample_period:.12f},{float(volts)!r}\n")
