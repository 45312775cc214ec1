"""`microgripper diagnose` as its users type it, on runs of 2 s and with few effects to try."""

from __future__ import annotations

import html
import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.diagnose import candidate_names
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.simulate import Initial, simulate

Run = Callable[..., Any]
PERIOD, NOISE = 1e-3, 5e-9
PATIENCE = 120.0  # s
TIME = PERIOD * np.arange(2000)
# A whole period, rough enough for the samples to show how the voltage runs between them.
VOLTAGE = 75.0 + sum(
    size * np.sin(2.0 * np.pi * frequency * TIME + frequency)
    for size, frequency in ((40.0, 0.5), (15.0, 7.0), (5.0, 60.0), (5.0, 130.0))
)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    save_model(nominal_model(), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def write(path: Path, displacement: Array, voltage: Array = VOLTAGE) -> Path:
    table = np.column_stack([PERIOD * np.arange(len(voltage)), voltage, displacement])
    header = "time_s,voltage_V,displacement_m"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.12g")
    return path


def noise() -> Array:
    return NOISE * np.random.default_rng(0).standard_normal(len(VOLTAGE))


@pytest.fixture
def straight(tmp_path: Path) -> Path:
    """A period of the nominal rig, whose voltage ran straight from sample to sample."""
    answer = simulate(nominal_model(), VOLTAGE, PERIOD, hold=Hold.FIRST, initial=Initial.PERIODIC)
    return write(tmp_path / "run.csv", answer + noise())


def trying(*names: str) -> list[str]:
    """The options that leave out all effects but some."""
    assert set(names) < set(candidate_names())
    left_out = [name for name in candidate_names() if name not in names]
    return ["--jobs", "1", *(word for name in left_out for word in ("--without", name))]


def diagnosed(microgripper: Run, out: Path, words: Sequence[object]) -> Any:  # noqa: ANN401
    done = microgripper("diagnose", *words, "--out", out, "--json")
    assert done.status == 0, done.err
    written = json.loads((out / "diagnosis.json").read_text())
    assert json.loads(done.out) == written
    return written


def test_the_conditions_are_those_that_are_asked_for(
    microgripper: Run, model: Path, straight: Path, tmp_path: Path
) -> None:
    chosen = ("--hold", "first", "--initial", "periodic")
    words = ("--model", model, straight, *chosen, *trying("creep"))
    found = diagnosed(microgripper, tmp_path / "out", words)
    assert (found["verdict"], found["warnings"]) == ("none", [])
    assert found["gap"]["nominal_rmse_m"] == pytest.approx(NOISE, rel=0.1)
    assert " ".join(chosen) in html.unescape((tmp_path / "out" / "report.html").read_text())


def test_a_hold_under_which_the_rig_would_fit_far_better_is_named(
    microgripper: Run, model: Path, straight: Path, tmp_path: Path
) -> None:
    words = ("--model", model, straight, *trying("creep"))
    (warning,) = diagnosed(microgripper, tmp_path / "out", words)["warnings"]
    assert warning.startswith("under --hold first a refit leaves ")
    assert "under --hold zero" in warning


def test_a_voltage_beyond_the_model_is_told_on_every_page(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    voltage = VOLTAGE + 40.0
    answer = simulate(nominal_model(), voltage, PERIOD) + noise()
    path = write(tmp_path / "run.csv", answer, voltage)
    out = tmp_path / "out"
    done = microgripper("diagnose", "--model", model, path, *trying("creep"), "--out", out)
    (warning,) = json.loads((out / "diagnosis.json").read_text())["warnings"]
    low, high = f"{voltage.min():g}", f"{voltage.max():g}"
    beyond = f"voltage {low} .. {high} V; the model holds for 0 .. 160 V"
    assert warning == f"{path}: {beyond}"
    assert beyond in html.unescape((out / "report.html").read_text())
    assert (done.err.count(beyond), done.out.count(beyond)) == (1, 0)


def test_what_no_effect_that_is_tried_explains_is_unknown(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    """A hum, without the hum in the library; it is still said where the gap lies."""
    hum = 2e-7 * np.sin(2.0 * np.pi * 50.0 * TIME)
    path = write(tmp_path / "run.csv", simulate(nominal_model(), VOLTAGE, PERIOD) + hum + noise())
    tried = ("creep", "transport_delay", "backlash", "amplifier_lag")
    words = ("--model", model, path, "--initial", "rest", *trying(*tried))
    found = diagnosed(microgripper, tmp_path / "out", words)
    assert (found["verdict"], found["effects"]) == ("unknown", [])
    first, *others = found["candidates"]
    assert first["effect"] == "unknown"
    assert first["probability"] > 0.9
    assert {one["effect"] for one in others} == {*tried, "none", "parameters"}
    bands = [place for place in found["where"] if place["axis"] == "frequency_Hz"]
    assert any(band["low"] <= 50.0 <= band["high"] for band in bands)


def test_one_that_is_asked_to_end_ends_its_workers(
    model: Path, straight: Path, tmp_path: Path
) -> None:
    words = ("diagnose", straight, "--model", model, "--out", tmp_path / "out", "--jobs", 2)
    command = [sys.executable, "-m", "microgripper_control", *map(str, words)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    deadline = time.monotonic() + PATIENCE
    while len(children.read_text().split()) < 3:  # two workers and one that tidies up
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.05)
    process.terminate()
    process.communicate(timeout=PATIENCE)  # workers that go on would keep its output open
    assert process.returncode == 130


def refused(microgripper: Run, out: Path, *words: object) -> str:
    """The one line that a diagnosis of bad input ends with; its folder, if made, stays empty."""
    done = microgripper("diagnose", *words, "--out", out)
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert not list(out.glob("*"))
    return str(done.err)


def test_a_recording_cannot_be_fitted_and_judge(
    microgripper: Run, model: Path, straight: Path, tmp_path: Path
) -> None:
    roundabout = tmp_path / ".." / tmp_path.name / straight.name
    words = ("--model", model, straight, "--heldout", roundabout)
    said = refused(microgripper, tmp_path / "out", *words)
    assert f"{straight} is also given to be fitted; give it one way only" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("still", ["voltage", "displacement"])
def test_a_recording_that_never_moves_is_refused(
    microgripper: Run, model: Path, tmp_path: Path, still: str
) -> None:
    moving = simulate(nominal_model(), VOLTAGE, PERIOD)
    ways = {"voltage": (moving, np.full(len(TIME), 40.0)), "displacement": (0.0 * moving, VOLTAGE)}
    path = write(tmp_path / "run.csv", *ways[still])
    said = refused(microgripper, tmp_path / "out", "--model", model, path)
    assert "run.csv: voltage or displacement never changes; record a run that moves" in said


def test_a_recording_too_short_for_a_diagnosis_is_refused(
    microgripper: Run, model: Path, tmp_path: Path
) -> None:
    answer = simulate(nominal_model(), VOLTAGE, PERIOD)
    path = write(tmp_path / "run.csv", answer[:99], VOLTAGE[:99])
    said = refused(microgripper, tmp_path / "out", "--model", model, path)
    assert "run.csv: 99 samples; a diagnosis needs 100" in said
