"""A mistyped command line gets one line that says what to type instead."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("identify", "x.csv", "--out", "y"), "'--model'"),
        (("identify", "--modell", "x"), "--modell"),
        (("identfy",), "identfy"),
        (("simulate", "--hold", "second", "x.csv"), "'--hold': 'second' is not one of"),
        (("demo", "--seed", "2147483648"), "--seed"),
        (("validate", "--seed", "-1", "--out", "x"), "--seed"),
        (("validate", "--jobs", "0", "--out", "x"), "-1 is one a core"),
    ],
)
def test_bad_usage_is_one_line(
    microgripper: Callable[..., Any], words: tuple[str, ...], says: str
) -> None:
    ran = microgripper(*words)
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert says in ran.err
    assert ran.err.endswith("--help\n")


def test_no_arguments_are_a_question_for_help(microgripper: Callable[..., Any]) -> None:
    ran = microgripper()
    assert (ran.status, ran.err) == (2, "")
    assert "identify" in ran.out


def test_help_is_no_error(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("identify", "--help")
    assert (ran.status, ran.err) == (0, "")
    assert "--model" in ran.out


def test_a_name_that_no_file_can_have_is_one_line(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("identify", "r.csv", "--model", "m" * 300, "--out", "y")
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert "too long" in ran.err


def test_an_output_that_is_full_is_one_line() -> None:
    words = [sys.executable, "-m", "microgripper_control", "effects"]
    with Path("/dev/full").open("w") as full:
        ran = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ran.returncode == 2
    assert ran.stderr == "microgripper: the output cannot be written: No space left on device\n"


def test_an_option_without_its_value_is_one_line(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("diagnose", "x.csv", "--heldout", "--model", "m", "--out", "y")
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert "--heldout" in ran.err


def test_a_diagnosis_does_not_replace_what_it_reads(
    microgripper: Callable[..., Any], tmp_path: Path
) -> None:
    """A second round begins from the model that the first has written."""
    save_model(nominal_model(), tmp_path / "model.yaml")
    before = (tmp_path / "model.yaml").read_text()
    run = tmp_path / "run.csv"
    run.write_text("time_s,voltage_V,displacement_m\n")
    words = ("diagnose", run, "--model", tmp_path / "model.yaml", "--out", tmp_path)
    done = microgripper(*words)
    assert done.status == 2
    assert f"{tmp_path}/model.yaml: would overwrite what is read" in done.err
    assert (tmp_path / "model.yaml").read_text() == before


@pytest.mark.parametrize("name", ["bouc_wen", "sensor_noise", "no_such_effect"])
def test_what_is_not_tried_cannot_be_left_out(
    microgripper: Callable[..., Any], tmp_path: Path, name: str
) -> None:
    words = ("diagnose", "run.csv", "--model", "m.yaml", "--out", tmp_path, "--without", name)
    done = microgripper(*words)
    assert (done.status, done.out) == (2, "")
    assert f"--without {name}: is no effect that is tried; those are " in done.err
    assert "creep" in done.err
