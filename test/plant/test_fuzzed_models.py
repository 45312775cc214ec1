"""Hostile model files: a model or one line that names the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from fuzzing import MUTATIONS, VALUES, fuzzed, mutated
from hypothesis import example, given
from hypothesis import strategies as st

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.model_file import load_model, save_model

pytestmark = pytest.mark.fuzz

Route = tuple[str | int, ...]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models") / "model.yaml"


@pytest.fixture(scope="module")
def whole(path: Path) -> str:
    save_model(nominal_model().with_link("creep").with_link("contact"), path)
    return path.read_text(encoding="utf-8")


def model_or_complaint(path: Path) -> Model | None:
    try:
        return load_model(path)
    except MicrogripperError as error:
        line = str(error)
    assert line.isprintable()
    assert line.startswith(str(path))
    return None


@fuzzed
@given(mutations=MUTATIONS)
def test_other_bytes(path: Path, whole: str, mutations: list[tuple[str, int, bytes]]) -> None:
    path.write_bytes(mutated(whole.encode(), mutations))
    model_or_complaint(path)


@fuzzed
@given(data=st.data(), value=VALUES)
def test_another_value_anywhere(path: Path, whole: str, data: st.DataObject, value: object) -> None:
    content: Any = yaml.safe_load(whole)
    place = content
    while True:
        key = data.draw(st.sampled_from(sorted(place)))
        if not isinstance(place[key], dict) or data.draw(st.booleans()):
            break
        place = place[key]
    place[key] = value
    path.write_text(yaml.safe_dump(content), encoding="utf-8", errors="replace")
    model_or_complaint(path)


@fuzzed
@given(text=st.text(alphabet="-:{}[]&*!|>'\"%@`#,? \n\t0aé~<=", max_size=40))
@example(text="!!python/object/apply:os.system ['true']")
@example(text="!!python/name:os.system")
@example(text="schema: &a microgripper-model/1\nname: *a\n")
@example(text="a: &a [x, x]\nb: &b [*a, *a]\nschema: [*b, *b]\n")
@example(text="[" * 5000)
@example(text="{" * 5000)
@example(text="? " * 3000)
@example(text="1" * 6000)
@example(text="2001-99-99")
@example(text="<<: 1")
@example(text="{[]: 1}")
def test_other_yaml(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    assert model_or_complaint(path) is None
