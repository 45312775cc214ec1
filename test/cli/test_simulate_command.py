"""`microgripper simulate` as its users type it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.simulate import Initial, simulate

Run = Callable[..., Any]
VOLTAGE = 80.0 - 80.0 * np.cos(2.0 * np.pi * 1e-3 * np.arange(2000))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    save_model(nominal_model(), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def write(path: Path, *columns: np.ndarray, header: str) -> Path:
    table = np.column_stack([1e-3 * np.arange(len(VOLTAGE)), *columns])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.17g")
    return path


def test_one_row_per_sample_without_a_measured_displacement(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    path = write(tmp_path / "drive.csv", VOLTAGE, header="time_s,voltage_V")
    out = tmp_path / "predicted.csv"
    done = microgripper("simulate", "--model", model, path, "--out", out)
    assert done.status == 0
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    assert out.read_text().splitlines()[0] == "time_s,displacement_m"
    assert np.allclose(rows[:, 0], 1e-3 * np.arange(len(VOLTAGE)), atol=1e-9)
    assert np.array_equal(rows[:, 1], simulate(nominal_model(), VOLTAGE, 1e-3))


@pytest.mark.parametrize(
    ("hold", "initial"), [(Hold.FIRST, Initial.PERIODIC), (Hold.BANDLIMITED, Initial.REST)]
)
def test_the_conditions_are_those_that_are_asked_for(
    microgripper: Run, model: Path, tmp_path: Path, hold: Hold, initial: Initial
) -> None:
    path = write(tmp_path / "drive.csv", VOLTAGE + 5.0, header="time_s,voltage_V")
    out = tmp_path / "predicted.csv"
    chosen = ("--hold", hold.value, "--initial", initial.value)
    assert microgripper("simulate", "--model", model, path, *chosen, "--out", out).status == 0
    said = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1]
    wanted = simulate(nominal_model(), VOLTAGE + 5.0, 1e-3, hold=hold, initial=initial)
    assert np.array_equal(said, wanted)


def test_the_recordings_own_zero_is_fitted_unless_told_not_to(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    measured = simulate(nominal_model(), VOLTAGE, 1e-3) + 5e-6
    path = write(tmp_path / "run.csv", VOLTAGE, measured, header="time_s,voltage_V,displacement_m")
    words = ("simulate", "--model", model, path, "--out", tmp_path / "p.csv", "--json")
    fitted = json.loads(microgripper(*words).out)
    assert fitted["schema"] == "microgripper-simulation/1"
    assert fitted["rmse_m"] < 1e-12
    plain = json.loads(microgripper(*words, "--nuisance", "none").out)
    assert plain["rmse_m"] == pytest.approx(5e-6, rel=1e-6)


def test_readings_too_far_for_an_error_are_told(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    far = np.where(np.arange(len(VOLTAGE)) % 2, 1e308, -1e308)
    path = write(tmp_path / "run.csv", VOLTAGE, far, header="time_s,voltage_V,displacement_m")
    done = microgripper("simulate", "--model", model, path, "--out", tmp_path / "p.csv", "--json")
    assert (done.status, done.out) == (2, "")
    assert done.err.count("\n") == 1
    assert "run.csv: displacement goes to 1e+308 m, too far for an error" in done.err
    assert not (tmp_path / "p.csv").exists()


def test_samples_that_were_missing_get_no_row(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    """Who joins prediction and recording by row must not be shifted from the first gap on."""
    path = write(tmp_path / "run.csv", VOLTAGE, header="time_s,voltage_V")
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:500] + lines[507:]))
    done = microgripper("simulate", "--model", model, path, "--out", tmp_path / "p.csv")
    assert done.status == 0
    times = [np.loadtxt(one, delimiter=",", skiprows=1)[:, 0] for one in (path, tmp_path / "p.csv")]
    assert np.allclose(*times, atol=1e-9)


def test_a_recording_is_not_overwritten(microgripper: Run, model: Path, tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", VOLTAGE, header="time_s,voltage_V")
    before = path.read_bytes()
    done = microgripper("simulate", "--model", model, path, "--out", path)
    assert (done.status, path.read_bytes()) == (2, before)
    assert "would overwrite" in done.err


@pytest.mark.parametrize("command", ["simulate", "identify", "diagnose"])
def test_millivolts_are_asked_about(
    microgripper: Run, model: Path, tmp_path: Path, command: str
) -> None:
    measured = simulate(nominal_model(), VOLTAGE, 1e-3)
    header = "time_s,voltage_V,displacement_m"
    path = write(tmp_path / "run.csv", 1e3 * VOLTAGE, measured, header=header)
    out = tmp_path / "out"
    done = microgripper(command, "--model", model, path, "--out", out)
    assert done.status == 2
    said = done.err.strip().splitlines()
    assert "the model holds for 0 .. 160 V" in said[0]
    assert "in volts?" in said[-1]
    assert not out.is_file()


def test_filled_in_samples_are_not_counted_whatever_is_fitted(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    measured = simulate(nominal_model(), VOLTAGE, 1e-3)
    kept = np.r_[:1100, 1300 : len(VOLTAGE)]
    table = np.column_stack([1e-3 * np.arange(len(VOLTAGE)), VOLTAGE, measured])[kept]
    path = tmp_path / "run.csv"
    header = "time_s,voltage_V,displacement_m"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.17g")
    words = ("simulate", "--model", model, path, "--out", tmp_path / "p.csv", "--json")
    assert json.loads(microgripper(*words, "--nuisance", "none").out)["rmse_m"] < 1e-9


def test_a_displacement_that_never_changes_has_no_relative_error(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    still = np.full(len(VOLTAGE), 1e-6)
    path = write(tmp_path / "run.csv", VOLTAGE, still, header="time_s,voltage_V,displacement_m")
    done = microgripper("simulate", "--model", model, path, "--out", tmp_path / "p.csv")
    assert done.status == 0
    assert "% of peak to peak" not in done.out
