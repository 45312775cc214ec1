"""`microgripper tune`: what it tells is what the controller takes, and what the loop's laws say."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model

Run = Callable[..., Any]  # as `microgripper` in conftest.py
MODEL = Path(__file__).parents[2] / "config" / "apa120s.yaml"


def test_it_tells_the_gains_of_the_rule_and_their_margins(microgripper: Run) -> None:
    """K ki = 1 / (2 * 1.5 T): the loop gain is 1/3 a sample, of which the margins are closed."""
    found = json.loads(microgripper("tune", "--model", MODEL, "--rate", "500", "--json").out)
    assert found["schema"] == "microgripper-tuning/1"
    plant = found["identified"]
    gain = plant["d"] * plant["k"] / (plant["k"] + plant["k_s"])
    assert found["gains"]["ki"] == pytest.approx(500.0 / (3.0 * gain))
    for margins, g in (found["margins"], 1 / 3), (found["margins_if_gain_is_higher"], 0.4):
        assert margins["gain"] == pytest.approx(1.0 / g, rel=1e-4)
        assert margins["phase"] == pytest.approx(90.0 - math.degrees(3.0 * math.asin(g / 2)))
        assert margins["crossover"] == pytest.approx(1000.0 * math.asin(g / 2), rel=1e-4)


def test_it_says_it_for_people(microgripper: Run) -> None:
    out = microgripper("tune", "--model", MODEL).out
    assert "142.1 nm/V" in out
    assert "18.4 kHz" in out  # sqrt((k + k_s) / m) / (2 pi)
    assert "53.3 Hz" in out


def test_gains_of_ones_own_stand_beside_what_suits(microgripper: Run) -> None:
    found = json.loads(microgripper("tune", "--model", MODEL, "--kp", "1e6", "--json").out)
    assert found["gains"]["kp"] == 1e6
    assert found["gains"]["ki"] == pytest.approx(2.345e9, rel=1e-3)
    alone = microgripper("tune", "--model", MODEL, "--kp", "1e6", "--ki", "0", "--json").out
    assert json.loads(alone)["margins"]["phase"] is None  # |L| = 0.14 at all frequencies
    assert "inf" not in microgripper("tune", "--model", MODEL, "--kp", "1e6", "--ki", "0").out
    assert microgripper("tune", "--model", MODEL, "--ki", "0").err == ""
    swings = microgripper("tune", "--model", MODEL, "--ki", "8e9")
    assert swings.status == 0
    assert "the loop is unstable with these gains" in swings.out


def test_what_cannot_be_is_told_in_one_line(microgripper: Run) -> None:
    for words, says in (
        (("--ki=-1",), "ki = -1 is outside its range 0 .. 1e+16 V/(m*s)"),
        (("--rate", "0"), "--rate"),
    ):
        outcome = microgripper("tune", "--model", MODEL, *words)
        assert outcome.status == 2
        assert says in outcome.err
        assert outcome.err.count("\n") == 1


def test_the_reach_is_told_as_the_sensor_reads_it_and_what_is_not_inverted_by_name(
    microgripper: Run, tmp_path: Path
) -> None:
    rig = nominal_model().with_link("sensor_zero", offset=5e-6).with_link("creep", strength=0.02)
    save_model(rig, tmp_path / "rig.yaml")
    out = microgripper("tune", "--model", tmp_path / "rig.yaml").out
    assert "5.00 to 25.9 µm" in out
    assert "Not in the feedforward, left to the PID: creep." in out
    usual = microgripper("tune", "--model", MODEL).out
    assert "0 to 20.9 µm" in usual
    assert "Not in" not in usual
