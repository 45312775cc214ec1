"""What goes wrong in the demo is the seed's choice, and within what the diagnosis can tell."""

from __future__ import annotations

from pathlib import Path

from microgripper_control.demo.fault import RANGES, drawn_fault, write_fault
from microgripper_control.demo.plan import true_model
from microgripper_control.plant.model_file import load_model


def test_each_fault_is_drawn_and_a_seed_draws_the_same_again() -> None:
    drawn = [drawn_fault(seed) for seed in range(20)]
    assert drawn == [drawn_fault(seed) for seed in range(20)]
    assert {fault.effect for fault in drawn} == set(RANGES)
    for fault in drawn:
        for name, value in fault.values.items():
            low, high = RANGES[fault.effect][name]
            assert low <= value <= high


def test_the_rig_has_the_fault_and_nothing_else(tmp_path: Path) -> None:
    fault = drawn_fault(1)
    model = load_model(write_fault(tmp_path, fault)[0])
    assert model.effects == (fault.effect,)
    assert {name: model.value(fault.effect, name) for name in fault.values} == fault.values
    assert model.without([fault.effect]) == true_model()
