"""A model whose drive range leaves the safe region says so."""

from __future__ import annotations

from dataclasses import replace

import pytest

from microgripper_control.plant.model import nominal_model


@pytest.mark.parametrize("limits", [(0.0, 160.0), (-20.0, 150.0), (-112.0, 112.0), (0.0, 224.0)])
def test_safe_ranges_are_silent(limits: tuple[float, float]) -> None:
    assert replace(nominal_model(), voltage_range=limits).warnings == ()


@pytest.mark.parametrize("limits", [(0.0, 226.0), (-113.0, 113.0)])
def test_a_range_too_wide_is_named_with_its_limit(limits: tuple[float, float]) -> None:
    (line,) = replace(nominal_model(), voltage_range=limits).warnings
    assert f"{limits[0]:g} .. {limits[1]:g} V" in line
    assert "224.7 V" in line
    assert "\n" not in line


def test_a_ratchet_is_never_safe() -> None:
    model = nominal_model().with_values({("bouc_wen", "beta"): -0.01})
    (line,) = model.warnings
    assert "beta < 0" in line
