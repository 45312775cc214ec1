"""`microgripper identify` as its users type it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import load_model, save_model
from microgripper_control.plant.simulate import Initial, simulate

Run = Callable[..., Any]
PERIOD = 1e-3
VOLTAGE = 80.0 - 75.0 * np.cos(2.0 * np.pi * PERIOD * np.arange(4000)) * np.linspace(1, 0.4, 4000)


def write(path: Path, voltage: Array, displacement: Array, header: str = "") -> Path:
    time = PERIOD * np.arange(len(voltage))
    table = np.column_stack([time, voltage, displacement])
    header = header or "time_s,voltage_V,displacement_m"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.12g")
    return path


@pytest.fixture
def model(tmp_path: Path) -> Path:
    changes = {("bouc_wen", "d"): 1.3e-7, ("bouc_wen", "alpha"): 0.09}
    save_model(nominal_model().with_values(changes), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    noise = 15e-9 * np.random.default_rng(0).standard_normal(len(VOLTAGE))
    return write(tmp_path / "run.csv", VOLTAGE, simulate(nominal_model(), VOLTAGE, PERIOD) + noise)


def test_writes_a_model_with_intervals_that_hold_the_truth(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    out = tmp_path / "new" / "fitted.yaml"
    done = microgripper("identify", "--model", model, recording, "--out", out)
    assert done.status == 0
    fitted = load_model(out)
    for name, truth in nominal_model().values("bouc_wen").items():
        setting = fitted.settings["bouc_wen"][name]
        assert setting.value == pytest.approx(truth, rel=0.02)
    assert "gain d k/(k + k_s)" in done.out
    assert "not determined: m, b" in done.out
    assert "% of peak to peak" in done.out


def test_a_wrong_unit_is_asked_about(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    words = ("--model", model, recording, "--map", "displacement=displacement_m*1e6")
    for command, out in (("identify", "fitted.yaml"), ("simulate", "predicted.csv")):
        done = microgripper(command, *words, "--out", tmp_path / out)
        assert done.status == 0
        assert "times as far as the model: make sure of the units" in done.err


def test_a_voltage_beyond_the_model_is_told_to_machines_too(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    voltage = VOLTAGE + 20.0
    path = write(tmp_path / "run.csv", voltage, simulate(nominal_model(), voltage, PERIOD))
    done = microgripper("identify", "--model", model, path, "--out", tmp_path / "f.yaml", "--json")
    (warning,) = json.loads(done.out)["warnings"]
    assert "the model holds for 0 .. 160 V" in warning
    assert warning in done.err


def test_a_model_that_leaves_more_than_noise_is_told(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    rig = nominal_model().with_link("backlash", play=3e-7)
    noise = 15e-9 * np.random.default_rng(0).standard_normal(len(VOLTAGE))
    other = write(tmp_path / "other.csv", VOLTAGE, simulate(rig, VOLTAGE, PERIOD) + noise)
    fitted = [
        microgripper("identify", "--model", model, path, "--out", tmp_path / "f.yaml")
        for path in (recording, other)
    ]
    assert "warning" not in fitted[0].err
    assert re.search(
        r"other\.csv: the model leaves \d+\.\d nm rms where the noise is", fitted[1].err
    )


@pytest.mark.parametrize("course", ["staircase", "sine"])
def test_a_coarse_sensor_is_no_misfit(microgripper: Run, tmp_path: Path, course: str) -> None:
    """Where the voltage rests or moves slowly, most readings of a 1 um sensor are repeated."""
    held = np.repeat(np.random.default_rng(1).uniform(0.0, 150.0, 14), 400)
    voltage = held if course == "staircase" else np.asarray(VOLTAGE - VOLTAGE[0])
    rig = nominal_model().with_link("sensor_quantization", resolution=1e-6)
    path = write(tmp_path / "run.csv", voltage, simulate(rig, voltage, PERIOD))
    save_model(nominal_model(), tmp_path / "model.yaml")
    words = ("--model", tmp_path / "model.yaml", path, "--initial", "rest", "--json")
    done = microgripper("identify", *words, "--out", tmp_path / "f.yaml")
    assert (done.status, done.err) == (0, "")
    (found,) = json.loads(done.out)["recordings"]
    assert found["white_noise_m"] == pytest.approx(found["rmse_m"], rel=0.3)


def test_readings_without_noise_are_a_misfit_however_few(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    voltage = np.repeat([0.0, 150.0, 30.0, 110.0, 60.0, 140.0, 5.0, 90.0], 400)
    lost = simulate(nominal_model().with_link("backlash", play=2e-6), voltage, PERIOD)
    path = write(tmp_path / "run.csv", voltage, lost)
    words = ("--model", model, path, "--initial", "rest", "--out", tmp_path / "f.yaml")
    done = microgripper("identify", *words)
    assert done.status == 0
    assert "nm rms where the noise is 0.0 nm" in done.err


def test_json_is_for_machines(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    done = microgripper(
        "identify", "--model", model, recording, "--out", tmp_path / "f.yaml", "--json"
    )
    result = json.loads(done.out)
    gain = result["parameters"]["gain"]
    assert gain["unit"] == "m/V"
    assert gain["low"] < gain["value"] < gain["high"]
    assert gain["value"] == pytest.approx(1.4447e-7 * 5e7 / (5e7 + 8.2e5), rel=1e-3)
    assert result["recordings"][0]["rmse_m"] == pytest.approx(15e-9, rel=0.1)


def test_the_conditions_are_those_that_are_asked_for(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    """A period of a steady state, under a voltage that ran straight from sample to sample."""
    angle = 2.0 * np.pi * np.arange(1000) / 1000
    voltage = 80.0 - 50.0 * np.cos(angle) - 20.0 * np.cos(3.0 * angle)
    measured = simulate(nominal_model(), voltage, PERIOD, hold=Hold.FIRST, initial=Initial.PERIODIC)
    path = write(tmp_path / "run.csv", voltage, measured)
    chosen = ("--hold", "first", "--initial", "periodic")
    words = ("--model", model, path, *chosen, "--out", tmp_path / "f.yaml", "--json")
    (found,) = json.loads(microgripper("identify", *words).out)["recordings"]
    assert found["rmse_m"] < 1e-10
    assert found["initial_hysteresis_m"] == 0.0  # it follows from the period


def test_other_peoples_columns_and_units(microgripper: Run, model: Path, tmp_path: Path) -> None:
    measured = simulate(nominal_model(), VOLTAGE, PERIOD)
    path = write(tmp_path / "theirs.csv", VOLTAGE / 20.0, 1e6 * measured, "time_s,daq_V,x_um")
    maps = ("--map", "voltage=daq_V*20", "--map", "displacement=x_um*1e-6")
    done = microgripper("identify", "--model", model, path, *maps, "--out", tmp_path / "f.yaml")
    assert done.status == 0
    assert load_model(tmp_path / "f.yaml").value("bouc_wen", "alpha") == pytest.approx(0.0801, 1e-3)


def test_bad_input_is_one_line_and_leaves_nothing(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    path = write(tmp_path / "bad.csv", VOLTAGE, np.full(len(VOLTAGE), np.nan))
    out = tmp_path / "f.yaml"
    for words in (
        ("--model", model, path),
        ("--model", model, tmp_path / "missing.csv"),
        ("--model", tmp_path / "missing.yaml", path),
    ):
        done = microgripper("identify", *words, "--out", out)
        assert done.status == 2
        assert len(done.err.strip().splitlines()) == 1
        assert not out.exists()


def test_a_recording_given_twice_would_count_twice(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy.csv"
    copy.write_bytes(recording.read_bytes())
    for command in ("identify", "diagnose"):
        done = microgripper(command, "--model", model, recording, copy, "--out", tmp_path / "out")
        assert (done.status, done.err.count("\n")) == (2, 1)
        assert "copy.csv: has the same samples as" in done.err


def test_frozen_parameters_leave_the_mechanics_to_be_fitted(
    microgripper: Run, recording: Path, tmp_path: Path
) -> None:
    settings = nominal_model().settings
    for frozen, status in ((["bouc_wen"], 0), (["bouc_wen", "second_order"], 2)):
        changes = {
            (link, name): replace(setting, frozen=True)
            for link in frozen
            for name, setting in settings[link].items()
        }
        path = tmp_path / "frozen.yaml"
        save_model(nominal_model().with_settings(changes), path)
        done = microgripper("identify", "--model", path, recording, "--out", tmp_path / "f.yaml")
        assert done.status == status
    assert "frozen" in done.err


def test_the_model_it_begins_with_is_not_replaced(
    microgripper: Run, model: Path, recording: Path
) -> None:
    before = model.read_text()
    done = microgripper("identify", recording, "--model", model, "--out", model)
    assert done.status == 2
    assert "would overwrite what is read" in done.err
    assert model.read_text() == before


def test_a_frozen_gain_is_as_given(
    microgripper: Run, model: Path, recording: Path, tmp_path: Path
) -> None:
    text = model.read_text()
    frozen = re.sub(r"(\bd: \{value: [^,}]+)", r"\1, frozen: true", text, count=1)
    assert frozen != text
    model.write_text(frozen)
    done = microgripper("identify", recording, "--model", model, "--out", tmp_path / "f.yaml")
    assert done.status == 0, done.err
    assert "as given" in done.out
    assert "nan .." not in done.out
