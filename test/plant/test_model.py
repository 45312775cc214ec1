"""Models are checked at birth and never change."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError, replace

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.plant.model import Model, Setting, nominal_model


@pytest.fixture
def model() -> Model:
    return nominal_model().with_link("creep", strength=0.02)


def test_the_nominal_model_is_the_paper_s(model: Model) -> None:
    plain = nominal_model()
    assert list(plain.settings) == ["bouc_wen", "second_order"]
    assert plain.effects == ()
    assert plain.values("bouc_wen")["alpha"] == 0.0801
    assert plain.values("second_order")["k_s"] == 8.2e5
    assert plain.voltage_range == (0.0, 160.0)


def test_nothing_of_it_can_be_changed(model: Model) -> None:
    with pytest.raises(FrozenInstanceError):
        model.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        model.settings["creep"] = {}  # type: ignore[index]
    with pytest.raises(TypeError):
        model.settings["creep"]["strength"] = Setting(0.5)  # type: ignore[index]
    with pytest.raises(FrozenInstanceError):
        model.settings["creep"]["strength"].value = 0.5  # type: ignore[misc]


def test_nor_through_what_it_was_made_of(model: Model) -> None:
    given = {name: dict(settings) for name, settings in model.settings.items()}
    made = replace(model, settings=given)
    given["creep"]["strength"] = Setting(0.5)
    del given["bouc_wen"]
    assert made.value("creep", "strength") == 0.02
    made.values("creep")["strength"] = 0.5
    assert made.value("creep", "strength") == 0.02


def test_changes_make_another_model(model: Model) -> None:
    changed = model.with_values({("bouc_wen", "d"): 2e-7, ("creep", "strength"): 0.03})
    assert (changed.value("bouc_wen", "d"), changed.value("creep", "strength")) == (2e-7, 0.03)
    assert (model.value("bouc_wen", "d"), model.value("creep", "strength")) == (1.4447e-7, 0.02)
    assert changed.without(["creep"]).effects == ()
    assert changed.effects == ("creep",)


def test_a_new_value_drops_the_old_interval_and_keeps_the_frost(model: Model) -> None:
    setting = Setting(1.5e-7, (1.4e-7, 1.6e-7), frozen=True)
    fitted = model.with_settings({("bouc_wen", "d"): setting})
    assert fitted.settings["bouc_wen"]["d"] == setting
    moved = fitted.with_values({("bouc_wen", "d"): 1.7e-7}).settings["bouc_wen"]["d"]
    assert moved == Setting(1.7e-7, None, frozen=True)


def test_links_stand_in_the_order_of_the_chain(model: Model) -> None:
    wider = model.with_link("sensor_noise").with_link("transport_delay").with_link("friction")
    order = ["transport_delay", "bouc_wen", "creep", "second_order", "friction", "sensor_noise"]
    assert list(wider.settings) == order
    assert [link.name for link in wider.links] == order


def test_a_link_that_is_off_is_absent(model: Model) -> None:
    off = model.with_values({("creep", "strength"): 0.0})
    assert off.effects == ("creep",)
    assert "creep" not in [link.name for link in off.links]


def test_it_travels_between_processes(model: Model) -> None:
    copy = pickle.loads(pickle.dumps(model))
    assert copy == model
    assert copy.origin == model.origin
    with pytest.raises(TypeError):
        copy.settings["creep"] = {}


def test_the_origin_is_no_part_of_the_model(model: Model) -> None:
    assert replace(model, origin="elsewhere.yaml") == model


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({("bouc_wen", "alpha"): 1.2}, ("bouc_wen", "alpha = 1.2", "0 .. 0.95")),
        ({("second_order", "m"): 0.0}, ("second_order", "m = 0", "1e-09 .. 1000 kg")),
        ({("creep", "strength"): float("nan")}, ("creep", "strength = nan", "0 .. 1")),
        ({("creep", "slowest"): float("inf")}, ("creep", "slowest = inf")),
    ],
)
def test_a_value_out_of_range_is_named(
    model: Model, change: dict[tuple[str, str], float], words: tuple[str, ...]
) -> None:
    with pytest.raises(MicrogripperError) as caught:
        replace(model, origin="rig.yaml").with_values(change)
    assert all(word in str(caught.value) for word in ("rig.yaml", *words))
    assert "\n" not in str(caught.value)


def test_what_is_unknown_or_missing_is_named(model: Model) -> None:
    with pytest.raises(MicrogripperError, match=r"unknown link 'crepe'; known are .*creep"):
        model.with_link("crepe")
    with pytest.raises(MicrogripperError, match="creep: unknown key 'strenght'"):
        model.with_link("creep", strenght=1.0)
    with pytest.raises(MicrogripperError, match="nominal: second_order is missing"):
        model.without(["second_order"])
    for settings in ({}, {"strength": Setting(0.1), "fastest": Setting(1.0)}):
        with pytest.raises(MicrogripperError, match=r"creep: \w+ is missing; allowed is"):
            replace(model, settings={**model.settings, "creep": settings})
    with pytest.raises(MicrogripperError, match=r"voltage: low 5 must be below high 5"):
        replace(model, voltage_range=(5.0, 5.0))


def test_bounds_that_the_data_leave_open_are_none() -> None:
    assert Setting(1.0).ends == (None, None)
    assert Setting(1.0, (-math.inf, 2.0)).ends == (None, 2.0)


def test_what_a_controller_does_not_know_of_a_model_is_named(model: Model) -> None:
    """Its delays, lags and modes it reckons with, and the sensor's zero; noise is no law."""
    known = model.with_link("sensor_zero", offset=2e-6).with_link("transport_delay", delay=1e-3)
    for name in ("sensor_lag", "extra_resonance", "sensor_noise", "sensor_quantization"):
        known = known.with_link(name)
    assert known.beside_the_inverse == ("creep",)
    assert known.zero == 2e-6
    assert model.zero == 0.0
    assert nominal_model().beside_the_inverse == ()
