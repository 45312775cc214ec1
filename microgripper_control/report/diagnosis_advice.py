"""What to do with a diagnosis: the values to take over, the next experiment, how to repeat it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from microgripper_control.diagnosis.data.evidence import rms
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.diagnosis.result_file import MODEL, NEXT_EXPERIMENT
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Mask, blocks
from microgripper_control.plant.model import Key, Model
from microgripper_control.report.markup import Html, element, joined
from microgripper_control.report.wording import listed, number, scaled, span


def parameters(diagnosis: Diagnosis) -> Html | None:
    """The nominal model's own parameters that the fit has moved."""
    final = diagnosis.model
    moved = _moved(diagnosis.nominal, final)
    if not moved:
        return None
    models, titles = [diagnosis.nominal, final], ["parameter", "as given", "refitted"]
    if diagnosis.effects:
        models.insert(1, diagnosis.refit)
        titles.append("with effects")
    rows = [_parameter(key, models) for key in moved]
    known = any(final.settings[link][name].interval for link, name in moved)
    titles.append("95 %" if known else "")
    head = element("tr", *(element("th", title, scope="col") for title in titles))
    table = element("table", element("thead", head), element("tbody", joined(*rows)))
    return element(
        "section",
        element("h2", "The model's own parameters"),
        element("div", table, class_="scroll"),
        element(
            "p",
            "Where an effect was missing, the refit alone bends these towards it; the last values "
            f"belong to {MODEL}."
            if diagnosis.effects
            else f"The values of {MODEL}.",
            class_="note",
        ),
    )


def _moved(nominal: Model, final: Model) -> list[Key]:
    return [
        (link, name)
        for link, settings in nominal.settings.items()
        for name in settings
        if link in final.settings and final.value(link, name) != nominal.value(link, name)
    ]


def _parameter(key: Key, models: Sequence[Model]) -> Html:
    (link, name), final = key, models[-1]
    unit = registry()[link].parameter(name).unit
    factor, prefixed = scaled(unit, final.value(link, name))
    values = (number(factor * model.value(link, name), 4) for model in models)
    interval = final.settings[link][name].interval
    ends = [factor * end for end in interval] if interval else []
    return element(
        "tr",
        element("th", name, element("small", prefixed), scope="row"),
        *(element("td", value, class_="number") for value in values),
        element("td", span(ends[0], ends[1], "1", 4) if ends else "", class_="number"),
    )


def next_experiment(diagnosis: Diagnosis) -> Html | None:
    """The voltage to record next, and what for."""
    experiment = diagnosis.next_experiment
    if experiment is None:
        return None
    return element(
        "section",
        element("h2", "The next experiment"),
        element("p", experiment.why),
        element("p", _separated(experiment.separates)) if experiment.separates else None,
        figure(
            "next", "Voltage to apply", f"The samples are in {NEXT_EXPERIMENT}, beside this page."
        ),
    )


def _separated(effects: tuple[str, ...]) -> str:
    if len(effects) == 1:
        return f"It tells whether {listed(effects)} is at work."
    return f"It tells apart: {listed(effects)}."


def warnings(diagnosis: Diagnosis) -> Html | None:
    """What to know before the result is trusted."""
    if not diagnosis.warnings:
        return None
    items = element("ul", joined(*(element("li", text) for text in diagnosis.warnings)))
    return element("section", element("h2", "Warnings"), items, id="warnings")


def repeating(diagnosis: Diagnosis, folder: Path, maps: Sequence[str]) -> Html:
    """The commands that give the reported errors again, with the model that lies in `folder`.

    `maps` are the values of `--map` with which the recordings were read.
    """
    conditions = diagnosis.conditions
    options = [
        *("--hold", conditions.hold.value, "--initial", conditions.initial.value),
        *(word for one in maps for word in ("--map", one)),
        *("--out", "predicted.csv"),
    ]
    model = ("microgripper", "simulate", "--model", str(folder / MODEL))
    whole = [one.recording for one in diagnosis.judged if not one.recording.part]
    commands = [shlex.join([*model, recording.name, *options]) for recording in whole]
    return element(
        "section",
        element("h2", "How to repeat it"),
        element(
            "p",
            "Given where the diagnosis was made, each command prints the error of the final model "
            f"on one recording{_as_judged(diagnosis)}: the recording's own zero and initial state "
            "are fitted on blocks 1, 3, 5, 7, 9 of ten, the error is taken on the others."
            f"{_if_strips(diagnosis)}{_if_rounded(diagnosis)}{_if_parts(diagnosis)}",
        ),
        element("pre", element("code", "\n".join(commands)), tabindex="0"),
    )


def _if_parts(diagnosis: Diagnosis) -> str:
    """What to know where recordings were cut."""
    if any(one.recording.part for one in diagnosis.judged):
        return " Of recordings that were cut at long gaps no command gives the parts."
    return ""


def _as_judged(diagnosis: Diagnosis) -> str:
    """What the commands repeat, unless fewer samples judged, or without rounding."""
    if _only_a_part(diagnosis) or _rounds(diagnosis):
        return ""
    return ", as it was judged here"


def _rounds(diagnosis: Diagnosis) -> bool:
    """Whether the final model rounds where the one that was given did not."""
    return diagnosis.model.rounding != diagnosis.nominal.rounding


def _if_rounded(diagnosis: Diagnosis) -> str:
    if not _rounds(diagnosis):
        return ""
    return " It rounds as the sensor does, which the error told here leaves out."


def _if_strips(diagnosis: Diagnosis) -> str:
    """What to know where half of the blocks that judge were fitted, too: what a command prints."""
    if not _only_a_part(diagnosis):
        return ""
    printed = [
        f"{1e9 * rms([(one.recording.measured - one.augmented)[counted]]):.1f} nm"
        for one, counted in zip(diagnosis.judged, _counted_by_a_command(diagnosis), strict=True)
        if not one.recording.part
    ]
    told = f", and over all of them it is {listed(tuple(printed))}" if printed else ""
    return f" Here half of these was fitted, too, or left out: the error told is of the rest{told}."


def _only_a_part(diagnosis: Diagnosis) -> bool:
    return any(
        np.count_nonzero(one.counted) < np.count_nonzero(counted)
        for one, counted in zip(diagnosis.judged, _counted_by_a_command(diagnosis), strict=True)
    )


def _counted_by_a_command(diagnosis: Diagnosis) -> list[Mask]:
    """The samples of each judging recording on which `simulate` takes its error."""
    return [
        blocks(len(one.recording), odd=False) & diagnosis.conditions.answered(one.recording)
        for one in diagnosis.judged
    ]


def figure(name: str, title: str, caption: str) -> Html:
    """The place of an interactive figure; the script fills it in."""
    return element(
        "figure",
        element("h3", title),
        element("div", class_="chart"),
        element("figcaption", caption),
        data_figure=name,
    )
