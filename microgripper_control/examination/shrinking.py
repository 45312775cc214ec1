"""How far each method brings the error down, on the same held-out samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from microgripper_control.examination.beside.compare import METHODS
from microgripper_control.examination.equals import AGREE
from microgripper_control.examination.marking import Marked
from microgripper_control.examination.plan import BLIND, PAIRS
from microgripper_control.examination.shares import Middle

DIAGNOSIS = "microgripper diagnose"


@dataclass(frozen=True)
class Errors:
    """Held-out rms errors of one case, m; `after` and `closed` by method.

    A method without an answer leaves what the refit leaves, and closes nothing. What only a
    diagnosis tells is None without one; its nominal and refitted errors are the sealed ones then.
    `closed` is the part of what the oracle closes: 1 - e(after) / e(refit) with
    e(r) = sqrt(max(r^2 - oracle^2, 0)).
    """

    name: str
    nominal: float
    refit: float
    oracle: float
    noise: float  # the sensor's
    floor: float | None  # what the diagnosis took for the noise
    after: dict[str, float]
    closed: dict[str, float]
    free_form: float | None


def errors_of(case: Marked) -> Errors:
    """Of one case; `closed` is empty where there is no gap to speak of."""
    gap, sealed = case.diagnosis["gap"] if case.diagnosis else {}, case.sealed
    refit = gap.get("refit_rmse_m", sealed.refit)
    after = {DIAGNOSIS: float(gap.get("augmented_rmse_m", refit))}
    for method in METHODS:
        beside = case.record.beside.get(method)
        if beside is not None:
            after[method] = refit if beside.rmse is None else beside.rmse
    removable = sealed.removable(refit)
    closed = {}
    if removable > AGREE * sealed.noise:
        closed = {name: 1.0 - sealed.removable(left) / removable for name, left in after.items()}
    return Errors(
        name=case.record.planned.name,
        nominal=gap.get("nominal_rmse_m", sealed.nominal),
        refit=refit,
        oracle=sealed.oracle,
        noise=sealed.noise,
        floor=gap.get("noise_floor_m"),
        after=after,
        closed=closed,
        free_form=gap.get("free_form_fraction"),
    )


def over_noise(errors: Sequence[Errors]) -> dict[str, Middle]:
    """Medians of the errors over the sensor's noise, in the order in which they shrink."""
    steps: dict[str, Callable[[Errors], float | None]] = {
        "nominal": lambda one: one.nominal,
        "refitted": lambda one: one.refit,
        "with the diagnosis": lambda one: one.after[DIAGNOSIS],
        "oracle": lambda one: one.oracle,
        "noise floor as diagnosed": lambda one: one.floor,
    }
    return {
        name: Middle.among([e / one.noise for one in errors if (e := error(one)) is not None])
        for name, error in steps.items()
    }


def closable(cases: Iterable[Marked]) -> list[Errors]:
    """Of the cases whose effects the library has and the recordings show."""
    found = []
    for case in cases:
        if case.sealed.question in (BLIND, PAIRS) and case.sealed.seen:
            errors = errors_of(case)
            if errors.closed:
                found.append(errors)
    return found
