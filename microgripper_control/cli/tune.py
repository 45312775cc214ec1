"""`microgripper tune`: the PID gains that suit a model, and how far a loop is from its limit."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.console import Console

from microgripper_control.cli.options import JsonOption, ModelOption, read_model
from microgripper_control.cli.tables import print_table
from microgripper_control.control.identified import Identified
from microgripper_control.control.pid import PidGains
from microgripper_control.control.tuning import (
    ACTING,
    GAIN_ERROR,
    Margins,
    gains_for,
    loop_margins,
)
from microgripper_control.core.quantities import number, quantity, span

SLOWEST, FASTEST = 0.1, 20_000.0  # Hz, as the controller's `sample_rate`
UNITS = {parameter.name: parameter.unit for parameter in PidGains.parameters()}
OWN = "instead of what suits the model"


def tune(
    model: ModelOption,
    rate: Annotated[
        float, typer.Option(metavar="HZ", min=SLOWEST, max=FASTEST, help="Samples a second.")
    ] = 1000.0,
    kp: Annotated[float | None, typer.Option(help=f"{UNITS['kp']}, {OWN}.")] = None,
    ki: Annotated[float | None, typer.Option(help=f"{UNITS['ki']}, {OWN}.")] = None,
    kd: Annotated[float | None, typer.Option(help=f"{UNITS['kd']}, {OWN}.")] = None,
    json_: JsonOption = False,
) -> None:
    """Tell which gains the controller takes for a model, and the margins these or others leave."""
    rig = read_model(model)
    identified = Identified.of(rig)
    asked = {
        name: gain for name, gain in zip(ACTING, (kp, ki, kd), strict=True) if gain is not None
    }
    gains = gains_for(identified, 1.0 / rate, asked)
    margins = [loop_margins(identified, gains, 1.0 / rate, factor) for factor in (1.0, GAIN_ERROR)]
    if json_:
        typer.echo(json.dumps(_plain(identified, gains, margins), allow_nan=False))
        return
    console = Console(highlight=False)
    print_table(console, ("plant, by the model", ""), _plant_rows(identified), texts=(0, 1))
    print_table(console, ("gain", "value", "unit"), _gain_rows(gains), texts=(0, 2))
    if left := rig.beside_the_inverse:
        console.print(f"Not in the feedforward, left to the PID: {', '.join(left)}.")
    if not margins[0].gain:
        console.print("By the model the loop is unstable with these gains.")
        return
    header = ("loop", "gain as identified", f"{GAIN_ERROR:g} times that")
    print_table(console, header, _margin_rows(margins))


def _plant_rows(identified: Identified) -> Sequence[tuple[str, str]]:
    low, high = identified.voltage_range
    lowest, highest = (end + identified.zero for end in identified.reach(low, high))
    natural = math.sqrt((identified.k + identified.k_s) / identified.m)  # rad/s
    return [
        ("gain at rest, without hysteresis", f"{quantity(identified.gain, 'm', 4)}/V"),
        ("reach, from rest on", span(lowest, highest, "m", 3)),
        ("reading at x = 0", quantity(identified.zero, "m", 3)),
        ("voltage", span(low, high, "V", 3)),
        ("natural frequency", quantity(natural / (2.0 * math.pi), "Hz", 3)),
        ("damping ratio", number(identified.b / (2.0 * identified.m * natural), 3)),
        ("delays and lags", quantity(identified.dead_time, "s", 3)),
        ("modes that ring", quantity(identified.ringing, "s", 3)),
    ]


def _gain_rows(gains: PidGains) -> Sequence[tuple[str, ...]]:
    return [(name, f"{getattr(gains, name):.4g}", unit) for name, unit in UNITS.items()]


def _margin_rows(margins: Sequence[Margins]) -> Sequence[tuple[str, ...]]:
    return [
        ("gain margin", *(f"{one.gain:.3g}" for one in margins)),
        (
            "phase margin",
            *(f"{one.phase:.3g} deg" if one.crossover else "no crossover" for one in margins),
        ),
        ("crossover", *(quantity(one.crossover / (2.0 * math.pi), "Hz", 3) for one in margins)),
    ]


def _plain(identified: Identified, gains: PidGains, margins: Sequence[Margins]) -> dict[str, Any]:
    """For JSON, SI units; null where no frequency bounds a margin."""
    as_identified, raised = map(_finite, map(asdict, margins))
    return {
        "schema": "microgripper-tuning/1",
        "identified": asdict(identified),
        "gains": asdict(gains),
        "margins": as_identified,
        "margins_if_gain_is_higher": {"factor": GAIN_ERROR, **raised},
    }


def _finite(values: Mapping[str, float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in values.items()}
