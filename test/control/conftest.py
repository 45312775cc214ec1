"""The paper's plant and its values as a controller holds them."""

from __future__ import annotations

import pytest
from closed_loop import identified_from

from microgripper_control.control.identified import Identified
from microgripper_control.plant.model import Model, nominal_model


@pytest.fixture(scope="session")
def model() -> Model:
    return nominal_model()


@pytest.fixture(scope="session")
def identified(model: Model) -> Identified:
    return identified_from(model)
