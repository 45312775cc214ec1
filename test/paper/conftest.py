"""The paper's plant, and its reproduction, which takes half a minute and is made once."""

from __future__ import annotations

import pytest

from microgripper_control.control.identified import Identified
from microgripper_control.paper.reproduction import STAGES, Reproduction, reproduce
from microgripper_control.plant.model import Model, nominal_model


@pytest.fixture(scope="session")
def plant() -> Model:
    return nominal_model()


@pytest.fixture(scope="session")
def identified(plant: Model) -> Identified:
    return Identified.of(plant)


@pytest.fixture(scope="session")
def reproduction() -> Reproduction:
    stages: list[str] = []
    result = reproduce(stages.append)
    assert len(stages) == STAGES
    return result
