"""The model as given, its refit and the explanation side by side, on all judging samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

from microgripper_control.diagnosis.answers.shrinkage import closed_fraction, closed_interval
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.findings import Gap, Judged
from microgripper_control.diagnosis.fits.trial import Trial, judged
from microgripper_control.plant.model import Model


@dataclass(frozen=True)
class Comparison:
    """Three trials, judged alike; where the nominal model's readings are rounded, all are."""

    evidence: Evidence
    nominal: Trial
    refit: Trial
    augmented: Trial

    @classmethod
    def of(
        cls, whole: Evidence, compared: Evidence, nominal: Trial, refit: Trial, augmented: Trial
    ) -> Comparison:
        """Of trials that were judged on `compared`, which is `whole` or a part of it."""
        foretold = (nominal, refit, _as_it_foretells(compared, augmented))
        return cls(whole, *(_on_all(whole, compared, trial, nominal.model) for trial in foretold))

    def gap(self, floor: float, free_form: float) -> Gap:
        """How far it shrinks; `floor` is of the noise, m, `free_form` what could be explained."""
        before, refit, augmented = self.nominal, self.refit, self.augmented
        if before.model.rounding:  # which way a reading is rounded no model foretells
            floor = min(trial.noise_floor for trial in (before, refit, augmented))
        low, high = closed_interval(refit.errors, augmented.errors, floor)
        return Gap(
            nominal=before.rmse,
            refit=refit.rmse,
            augmented=augmented.rmse,
            noise_floor=floor,
            closed=closed_fraction(refit.rmse, augmented.rmse, floor),
            closed_low=low,
            closed_high=high,
            free_form=free_form,
            separate=self.evidence.apart,
        )

    def judged(self, usual: float) -> tuple[Judged, ...]:
        """What the three say about each judging recording; `usual`, m, is the refit's mean zero."""
        models = (trial.model for trial in (self.nominal, self.refit, self.augmented))
        said = [self.evidence.predictions(model) for model in models]
        return tuple(
            Judged(
                recording,
                before.counted,
                before.prediction,
                after.prediction,
                last.prediction,
                after.zero - usual,
            )
            for recording, before, after, last in zip(self.evidence.judged, *said, strict=True)
        )


def _as_it_foretells(evidence: Evidence, trial: Trial) -> Trial:
    """An explanation, its readings rounded by a grid or as they are before: what comes nearer.

    Which way a reading is rounded no model foretells; where it is off by much of a step, to round
    its prediction as well only adds to that.
    """
    if not trial.model.rounding:
        return trial
    smooth = judged(evidence, replace(trial, model=trial.model.without(trial.model.rounding)))
    return min(trial, smooth, key=lambda one: one.both)


def _on_all(whole: Evidence, compared: Evidence, trial: Trial, nominal: Model) -> Trial:
    """A trial judged on all judging samples, by readings that are rounded if `nominal` has it."""
    model = trial.model.with_rounding_of(nominal)
    if model is trial.model and whole is compared:
        return trial
    return judged(whole, replace(trial, model=model))
