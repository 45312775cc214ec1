"""YAML is read as plain data, and what would explode is refused before it is built."""

from __future__ import annotations

import pytest

from microgripper_control.core import safe_yaml
from microgripper_control.core.safe_yaml import load_yaml

REFUSED = {
    "a: &x 1\nb: *x": "line 2: aliases",
    # libyaml reads ahead, and since PyYAML 6.0.4 meets a limit of its own first
    "[" * 100_000: "nested too deeply|maximum nesting depth",
    "a: " * 3 + "1": "mapping values",
    "!!python/object:os.system 1": "could not determine a constructor",
    "a: 1\n---\na: 2": "but found another document",
    "a: [1, 2": "while parsing a flow sequence",
    "{{1: 2}: 3}": "unhashable",
    "a:\n  b: 1\n  b: 2": "line 3: 'b' is given twice",
}


@pytest.mark.parametrize("loader", ["SafeLoader", "CSafeLoader"])
@pytest.mark.parametrize("text", REFUSED, ids=list(REFUSED.values()))
def test_what_is_not_plain_data_is_refused_in_one_line(
    text: str, loader: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    yaml = pytest.importorskip("yaml")
    monkeypatch.setattr(safe_yaml, "LOADER", getattr(yaml, loader, yaml.SafeLoader))
    with pytest.raises(ValueError, match=REFUSED[text]) as refused:
        load_yaml(text)
    assert "\n" not in str(refused.value)


def test_plain_data_is_read() -> None:
    text = "a: 1.5\nb: [1, two, ~]\nc: {d: true}\n"
    assert load_yaml(text) == {"a": 1.5, "b": [1, "two", None], "c": {"d": True}}
    assert load_yaml("[" * 100 + "]" * 100) is not None
    assert load_yaml("") is None
