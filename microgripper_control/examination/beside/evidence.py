"""The recordings of a case as its user has them, and the refit that other methods begin at."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.identification.nuisance import (
    Conditions,
    Mask,
    blocks,
    heldout_prediction,
)
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model_file import load_model
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording
from microgripper_control.validation.case_files import JOB


@dataclass(frozen=True)
class Rest:
    """One recording with what the refitted model predicts and leaves, m, shape (n,) each."""

    recording: Recording
    predicted: Array
    left: Array
    counted: Mask  # the samples to be fitted, or to be judged on


@dataclass(frozen=True)
class Begun:
    """Where every other method begins."""

    evidence: Evidence
    nominal: Trial
    refit: Trial

    @classmethod
    def read(cls, case: Path) -> Begun:
        """From the folder that the diagnosing process gets."""
        job = json.loads((case / JOB).read_text(encoding="utf-8"))
        nominal = load_model(case / job["model"])
        given, heldout = (
            [read_recording(case / name, Mapping.parse([])) for name in job[kind]]
            for kind in ("recordings", "heldout")
        )
        evidence = Evidence.gather(given, heldout, Conditions(Hold(job["hold"])), nominal)
        before = nominal_trial(evidence, nominal)
        return cls(evidence, before, refit_trial(evidence, before))

    def training(self) -> list[Rest]:
        """What the refit leaves of the recordings that are fitted."""
        conditions, model = self.evidence.conditions, self.refit.model
        found = []
        for recording in self.evidence.fitted:
            predicted = heldout_prediction(model, recording, conditions).prediction
            left = recording.measured - predicted
            counted = conditions.answered(recording)
            found.append(Rest(recording, predicted, left - left[counted].mean(), counted))
        return found

    def judging(self) -> list[Rest]:
        """What it leaves of those that judge."""
        found = []
        for recording in self.evidence.judged:
            predicted, counted, _ = heldout_prediction(
                self.refit.model, recording, self.evidence.conditions
            )
            found.append(Rest(recording, predicted, recording.measured - predicted, counted))
        return found


def rmse_without(judging: list[Rest], explained: list[Array]) -> float:
    """The error, m, that is left of judging recordings when a method has had its say.

    `explained` is what it adds to each prediction, m. The zero of a recording is its own, and is
    fitted on the blocks that do not judge, as everywhere.
    """
    errors = []
    for rest, added in zip(judging, explained, strict=True):
        error = rest.left - added
        own = blocks(len(error), odd=True) & rest.recording.explained
        errors.append((error - error[own].mean())[rest.counted])
    return rms(errors)
