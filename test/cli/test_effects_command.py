"""`microgripper effects` tells what a model file may hold."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from microgripper_control.effects.registry import registry

Run = Callable[..., Any]


def test_every_link_is_listed(microgripper: Run) -> None:
    done = microgripper("effects")
    assert done.status == 0
    assert all(name in done.out for name in registry())


def test_the_parameters_of_one_have_units_and_ranges(microgripper: Run) -> None:
    done = microgripper("effects", "backlash")
    assert done.status == 0
    (row,) = [line for line in done.out.splitlines() if line.strip().startswith("play ")]
    assert row.split()[:4] == ["play", "m", "2e-07", "0"]
    assert "width of the gap" in row
    assert "Krasnosel" in done.out


def test_for_machines_all_is_there(microgripper: Run) -> None:
    links = json.loads(microgripper("effects", "--json").out)["links"]
    assert {link["name"]: len(link["parameters"]) for link in links} == {
        name: len(link.parameters) for name, link in registry().items()
    }


def test_one_that_does_not_exist_is_named_beside_those_that_do(microgripper: Run) -> None:
    done = microgripper("effects", "krieep")
    assert done.status == 2
    assert "unknown link 'krieep'; known are transport_delay" in done.err
