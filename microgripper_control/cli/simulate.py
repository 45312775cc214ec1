"""`microgripper simulate`: what the model predicts for a recording's voltage."""

from __future__ import annotations

import enum
import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from microgripper_control.cli.options import (
    HoldOption,
    InitialOption,
    JsonOption,
    MapOption,
    ModelOption,
    read_all,
    read_model,
    warn_of_misuse,
)
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import check_place, written_whole
from microgripper_control.core.recording import Recording
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    heldout_prediction,
    predict,
    refuse_divergence,
)
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.simulate import Initial


class NuisanceFit(str, enum.Enum):
    """Whether the recording's own values are fitted before it is predicted."""

    FIT = "fit"
    NONE = "none"


def simulate(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING")],
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", metavar="PREDICTED.csv")],
    maps: MapOption = None,
    hold: HoldOption = Hold.ZERO,
    initial: InitialOption = Initial.FIRST_SAMPLE,
    nuisance: Annotated[
        NuisanceFit,
        typer.Option(
            help="fit: the recording's zero and initial state are fitted on blocks 1, 3, 5, 7, 9 of"
            " ten, errors taken on the others; none: both are zero."
        ),
    ] = NuisanceFit.FIT,
    json_: JsonOption = False,
) -> None:
    """Predict a recording's displacement with a model; one row per sample."""
    rig = read_model(model)
    check_place(out, [recording, model])
    given = read_all([recording], maps, needs_displacement=False)[0]
    conditions = Conditions(hold, initial)
    warn_of_misuse(rig, [given], conditions)
    counted = given.explained
    with np.errstate(all="ignore"):  # what a damaged file holds may overflow: it is told
        if given.displacement is not None and nuisance is NuisanceFit.FIT:
            prediction, counted, _ = heldout_prediction(rig, given, conditions)
        else:
            prediction = predict(rig, given, conditions, Nuisance())
    refuse_divergence(given, prediction)
    summary = _summary(given, prediction, counted)
    recorded = given.present  # one row for each sample that was recorded, none for those filled in
    with written_whole(out) as file:
        file.write("time_s,displacement_m\n")
        for time, value in zip(given.time[recorded], prediction[recorded], strict=True):
            file.write(f"{time:.9f},{float(value)!r}\n")
    if json_:
        named = {"recording": given.name, "predicted": str(out)}
        result = {"schema": "microgripper-simulation/1", **named, **summary}
        typer.echo(json.dumps(result, allow_nan=False))
        return
    typer.echo(f"{np.count_nonzero(recorded)} samples predicted: {out}")
    if summary:
        relative = summary.get("relative_rmse")
        of_span = "" if relative is None else f", {100.0 * relative:.3f} % of peak to peak"
        typer.echo(f"error {1e9 * summary['rmse_m']:.1f} nm rms{of_span}")


@np.errstate(all="ignore")  # what a damaged file holds may overflow: it is told
def _summary(recording: Recording, prediction: np.ndarray, counted: np.ndarray) -> dict[str, float]:
    measured = recording.displacement
    if measured is None:
        return {}
    rmse = float(np.sqrt(np.mean((measured - prediction)[counted] ** 2)))
    span = float(np.ptp(measured))
    if not np.isfinite([rmse, span]).all():
        raise MicrogripperError(
            f"{recording.name}: displacement goes to {np.max(np.abs(measured)):.3g} m, too far for "
            "an error; is it in metres? --map displacement=NAME*SCALE"
        )
    return {"rmse_m": rmse, **({"relative_rmse": rmse / span} if span > 0.0 else {})}
