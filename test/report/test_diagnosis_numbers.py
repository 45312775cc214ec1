"""What stands in the tables and figures of a report is what the diagnosis says."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from diagnoses import creeping
from packed_values import unpacked

from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.effects.base import Stage
from microgripper_control.plant.model import Setting
from microgripper_control.report.diagnosis_advice import parameters
from microgripper_control.report.diagnosis_candidates import candidates
from microgripper_control.report.diagnosis_chain import chain
from microgripper_control.report.diagnosis_figures import recording_figures
from microgripper_control.report.diagnosis_layers import layers
from microgripper_control.report.diagnosis_verdict import key_numbers
from microgripper_control.report.markup import Html
from microgripper_control.report.wording import TIMES

ERRORS = {"nominal": 431e-9, "refit": 87.1e-9, "augmented": 21.9e-9, "noise_floor": 13.7e-9}
STAGES = {"drive": 0.07, "material": 0.61, "mechanics": 0.17, "transmission": 0.04, "sensor": 0.11}


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    """No two of its numbers are alike."""
    made = creeping()
    numbers = ((0.53, 0.71, 35e-9, 0.84), (0.31, 0.22, 46e-9, 0.65))
    named = ("probability", "present", "rmse", "share")
    told = [
        replace(candidate, **dict(zip(named, each, strict=True)))
        for candidate, each in zip(made.candidates, numbers, strict=False)
    ]
    key = ("bouc_wen", "d")
    return replace(
        made,
        gap=replace(made.gap, **ERRORS),
        stages=STAGES,
        candidates=(*told, *made.candidates[2:]),
        nominal=made.nominal.with_settings({key: Setting(1.4e-7)}),
        refit=made.refit.with_settings({key: Setting(1.5e-7)}),
        model=made.model.with_settings({key: Setting(1.6e-7, (1.57e-7, 1.63e-7))}),
    )


def rows(html: Html | None) -> dict[str, list[str]]:
    """The texts of a table's cells by the text of the row's head."""
    found = {}
    for row in re.findall("<tr.*?</tr>", str(html).replace("\N{NO-BREAK SPACE}", " "), re.DOTALL):
        cells = [re.sub("<.*?>", "", c) for c in re.findall("<t[hd].*?</t[hd]>", row, re.DOTALL)]
        found[cells[0]] = cells[1:]
    return found


def test_each_model_has_its_own_error(found: Diagnosis) -> None:
    told = rows(key_numbers(found))
    floor = ERRORS["noise_floor"]
    for layer, digits in zip(layers(found), ("431", "87.1", "21.9"), strict=True):
        error = ERRORS[layer.field]
        assert told[layer.name][1] == f"{digits} nm"
        assert told[layer.name][2].startswith(f"{error / floor:.2g}")
    assert told["noise floor"][1] == "13.7 nm"


def test_each_candidate_has_its_own_numbers(found: Diagnosis) -> None:
    told = rows(candidates(found))
    assert told["creepmaterial"] == ["53 %", "71 %", "35.0 nm", "84 %"]
    assert told["thermal driftsensor"] == ["31 %", "22 %", "46.0 nm", "65 %"]


def test_each_stage_has_its_own_probability(found: Diagnosis) -> None:
    drawn = str(chain(found)).replace("\N{NO-BREAK SPACE}", " ")
    names = re.findall(r'class="stage"[^>]*>(.*?)<', drawn)
    shares = re.findall(r'class="share"[^>]*>(.*?)<', drawn)
    wanted = [(stage.value, f"{100.0 * STAGES[stage.value]:.0f} %") for stage in Stage]
    assert list(zip(names, shares, strict=True)) == 2 * wanted  # across, and down
    told = ", ".join(" ".join(pair) for pair in wanted)
    assert drawn.count(f"probabilities: {told};") == 2


def test_a_parameter_is_told_of_each_model_in_its_column(found: Diagnosis) -> None:
    told = rows(parameters(found))
    assert told["parameter"] == ["as given", "refitted", "with effects", "95 %"]
    (row,) = (cells for name, cells in told.items() if name.startswith("d"))
    power = f" {TIMES} 10⁻⁷"
    ends = f"1.570{power} to 1.630{power}"
    assert row == [*(f"{value}{power}" for value in ("1.400", "1.500", "1.600")), ends]


def test_what_is_drawn_is_measured_and_predicted_in_the_unit_that_stands_there(
    found: Diagnosis,
) -> None:
    judged = found.judged[0]
    measured, drawn = judged.recording.measured, recording_figures(found, judged)
    predicted = {layer.name: getattr(judged, layer.field) for layer in layers(found)}
    wanted = {
        ("response", "µm"): {
            "measured": 1e6 * measured,
            **{name: 1e6 * one for name, one in predicted.items()},
        },
        ("residual", "nm"): {name: 1e9 * (measured - one) for name, one in predicted.items()},
    }
    for (figure, unit), lines in wanted.items():
        shown: Any = drawn[figure]
        assert shown["y"]["unit"] == unit
        assert [line["name"] for line in shown["series"]] == list(lines)
        for line in shown["series"]:
            true = lines[line["name"]]
            np.testing.assert_allclose(unpacked(line["y"]), true, rtol=0, atol=1e-4 * np.ptp(true))
