"""A diagnosis made by hand: a rig that creeps, and the paper's model of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import (
    EFFECTS,
    NONE,
    PARAMETERS,
    UNKNOWN,
    Candidate,
    Diagnosis,
    Gap,
    Judged,
    NextExperiment,
    Range,
    Signature,
)
from microgripper_control.identification.nuisance import Conditions, heldout_prediction
from microgripper_control.plant.model import Model, Setting, nominal_model
from microgripper_control.plant.simulate import simulate

T = 1e-3
NOISE = 15e-9


def drive(samples: int, seed: int) -> Array:
    """A sine, then steps with rests, V."""
    half = samples // 2
    sine = 70.0 * (1.0 - np.cos(2.0 * np.pi * np.arange(half) * T))
    levels = np.random.default_rng(seed).uniform(5.0, 150.0, 8)
    return np.append(sine, np.repeat(levels, -(-(samples - half) // 8))[: samples - half])


def rms(signal: Array) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def creeping(
    names: tuple[str, ...] = ("first run", "second run"), samples: int = 4000
) -> Diagnosis:
    """The diagnosis of recordings of those names."""
    base = nominal_model()
    nominal = base.with_values({("bouc_wen", "d"): 1.4e-7})
    final = base.with_link("creep")
    conditions = Conditions()
    judged = tuple(
        _judged(name, seed, samples, (nominal, base, final), conditions)
        for seed, name in enumerate(names)
    )
    errors = {
        field: rms(
            np.concatenate([(j.recording.measured - getattr(j, field))[j.counted] for j in judged])
        )
        for field in ("nominal", "refit", "augmented")
    }
    return Diagnosis(
        verdict=EFFECTS,
        sentence="The rig creeps. Adding creep helps: 97 % [94, 99] of what could be removed.",
        effects=("creep",),
        candidates=_candidates(final),
        stages={"drive": 0.01, "material": 0.93, "mechanics": 0.02, "sensor": 0.03},
        gap=Gap(
            **errors,
            noise_floor=NOISE,
            closed=0.97,
            closed_low=0.94,
            closed_high=0.99,
            free_form=0.98,
            separate=False,
        ),
        where=(
            Range("frequency_Hz", 0.3, 3.0, 0.8),
            Range("hold_time_s", 0.01, 0.2, 0.6),
            Range("time_s", 2.0, 3.0, 0.5),
            Range("displacement_m", 5e-6, 9e-6, 0.4),
            Range("voltage_V", 40.0, 90.0, 0.4),
            Range("rate_V_per_s", -10.0, 10.0, 0.7),
            Range("direction", -1.0, -1.0, 0.6),
        ),
        ambiguous=(("creep", "thermal_drift"),),
        next_experiment=NextExperiment("Steps.", ("creep", "thermal_drift"), T, drive(1000, 9)),
        nominal=nominal,
        refit=base,
        model=final,
        conditions=conditions,
        judged=judged,
        shares={"creep": 0.97},
        warnings=("3 samples were missing",),
    )


def parameters_only() -> Diagnosis:
    """A diagnosis that needs no effect, of a recording that never rests."""
    found = creeping(("sine",), samples=2000)
    sine = found.judged[0].recording
    recording = Recording("sine", T, sine.voltage[:1000], sine.measured[:1000])
    short = {field: getattr(found.judged[0], field)[:1000] for field in ("nominal", "refit")}
    counted = found.judged[0].counted[:1000]
    judged = Judged(recording, counted, **short, augmented=short["refit"])
    nothing = {"effects": (), "where": (), "ambiguous": (), "shares": {}, "warnings": ()}
    return replace(
        found, **nothing, verdict=PARAMETERS, model=found.refit, judged=(judged,),
        next_experiment=None, stages={},
    )  # fmt: skip


def _judged(
    name: str, seed: int, samples: int, models: tuple[Model, ...], conditions: Conditions
) -> Judged:
    voltage = drive(samples, seed)
    noise = NOISE * np.random.default_rng(100 + seed).standard_normal(samples)
    recording = Recording(name, T, voltage, simulate(models[-1], voltage, T) + noise)
    predicted = [heldout_prediction(model, recording, conditions) for model in models]
    return Judged(recording, predicted[0].counted, *(one.prediction for one in predicted))


def _candidates(final: Model) -> tuple[Candidate, ...]:
    fitted = {
        name: Setting(value, (0.9 * value, float("inf")))
        for name, value in final.values("creep").items()
    }
    signatures = (
        Signature("creep", True, "In 8 rests the displacement goes on growing."),
        Signature("creep", None, "No rest is longer than 1 s."),
    )
    against = (Signature("thermal_drift", False, "The residual follows the voltage."),)
    return (
        Candidate("creep", "material", 0.93, 0.97, 1.5e-8, fitted, 0.97, signatures),
        Candidate("thermal_drift", "sensor", 0.04, 0.2, 4e-8, {}, 0.2, against),
        Candidate(UNKNOWN, None, 0.02, 0.02, None),
        Candidate("backlash", "transmission", 0.005, 0.01, None, note="the fit did not converge"),
        Candidate(PARAMETERS, None, 0.004, 0.004, 4e-8),
        Candidate(NONE, None, 0.001, 0.001, 4e-7),
    )
