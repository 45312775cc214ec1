"""`microgripper identify`: fit the model to recordings of its rig."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from microgripper_control.cli.options import (
    HoldOption,
    InitialOption,
    JsonOption,
    MapOption,
    ModelOption,
    read_all,
    read_model,
    warn,
    warn_of_misuse,
)
from microgripper_control.cli.tables import print_table
from microgripper_control.core.files import check_place
from microgripper_control.core.recording import refuse_twice
from microgripper_control.effects.registry import registry
from microgripper_control.identification.fit import Fit, fit
from microgripper_control.identification.nuisance import Conditions, zero_of
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Key, Setting, title
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.simulate import Initial

MISFIT, SMALL = 2.0, 1e-3  # times the noise, and of peak to peak: what leaves more is not the rig's
GAIN_TITLE = "gain d k/(k + k_s)"


def identify(
    recordings: Annotated[list[Path], typer.Argument(metavar="RECORDING...")],
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", metavar="FITTED.yaml")],
    maps: MapOption = None,
    hold: HoldOption = Hold.ZERO,
    initial: InitialOption = Initial.FIRST_SAMPLE,
    json_: JsonOption = False,
) -> None:
    """Fit a model's parameters to recordings; writes them with 95 % intervals."""
    nominal = read_model(model)
    check_place(out, [*recordings, model])
    given = read_all(recordings, maps)
    refuse_twice(given)
    conditions = Conditions(hold, initial)
    warnings = warn_of_misuse(nominal, given, conditions)
    with Console(stderr=True).status("reading") as status:
        found = fit(nominal, given, conditions, lambda stage: status.update(f"fit: {stage}"))
    save_model(found.model, out)
    _warn_of_misfits(found)
    if json_:
        typer.echo(
            json.dumps(as_json(found) | {"warnings": warnings, "fitted": str(out)}, allow_nan=False)
        )
        return
    console = Console(highlight=False, soft_wrap=True)
    header = ("parameter", "value", "95 % interval", "unit")
    print_table(console, header, parameter_rows(found), texts=range(len(header)))
    for reason, titles in undetermined(found).items():
        console.print(f"not determined: {', '.join(titles)}: {reason}", markup=False)
    for name, rmse, relative, white in zip(
        found.recordings, found.rmse, found.relative_rmse, found.white_noise, strict=True
    ):
        console.print(
            f"{name}: error {1e9 * rmse:.1f} nm rms, {100.0 * relative:.3f} % of peak to peak; "
            f"white noise in it: {1e9 * white:.1f} nm",
            markup=False,
        )
    console.print(f"written: {out}", markup=False)


def _warn_of_misfits(found: Fit) -> None:
    """Say on standard error where the model is not the rig's: its intervals are not, either."""
    for name, rmse, relative, white in zip(
        found.recordings, found.rmse, found.relative_rmse, found.white_noise, strict=True
    ):
        if rmse > MISFIT * white and relative > SMALL:
            warn(
                f"{name}: the model leaves {1e9 * rmse:.1f} nm rms where the noise is "
                f"{1e9 * white:.1f} nm, and the intervals "
                "hold only if it is right; microgripper diagnose says what is missing"
            )


def parameter_rows(found: Fit) -> Iterator[tuple[str, ...]]:
    """The identified values as people read them."""
    yield _row(GAIN_TITLE, found.gain, "m/V")
    for key in found.determined:
        yield _row(title(key), found.model.settings[key[0]][key[1]], _unit(key))


def undetermined(found: Fit) -> dict[str, list[str]]:
    """The parameters that stay at their nominal values, by reason."""
    by_reason: dict[str, list[str]] = {}
    for entry in found.undetermined:
        by_reason.setdefault(entry.reason, []).append(title(entry.key))
    return by_reason


def as_json(found: Fit) -> dict[str, Any]:
    """The result for other programs: SI units throughout."""
    parameters = {
        f"{link}.{name}": _plain(found.model.settings[link][name], _unit((link, name)))
        for link, name in found.determined
    }
    return {
        "schema": "microgripper-identification/1",
        "parameters": {"gain": _plain(found.gain, "m/V"), **parameters},
        "undetermined": {f"{u.key[0]}.{u.key[1]}": u.reason for u in found.undetermined},
        "recordings": [
            {
                "name": name,
                "rmse_m": rmse,
                "relative_rmse": relative,
                "white_noise_m": white,
                "offset_m": zero_of(found.model, nuisance),
                "initial_hysteresis_m": nuisance.initial_hysteresis,
            }
            for name, rmse, relative, white, nuisance in zip(
                found.recordings,
                found.rmse,
                found.relative_rmse,
                found.white_noise,
                found.nuisances,
                strict=True,
            )
        ],
    }


def _plain(setting: Setting, unit: str) -> dict[str, Any]:
    low, high = setting.ends
    return {"value": setting.value, "unit": unit, "low": low, "high": high}


def _row(name: str, setting: Setting, unit: str) -> tuple[str, str, str, str]:
    between = " .. ".join(f"{end:.5g}" for end in setting.interval or ()) or "as given"
    return name, f"{setting.value:.5g}", between, unit


def _unit(key: Key) -> str:
    return registry()[key[0]].parameter(key[1]).unit
