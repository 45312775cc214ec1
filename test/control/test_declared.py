from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from microgripper_control.control.declared import Declared, declared
from microgripper_control.core.errors import MicrogripperError


@dataclass(frozen=True)
class Oven(Declared):
    heat: float = declared("K", 300.0, 0.0, 1000.0, "temperature")
    trays: float = declared("1", 2, 1, 8, "number of trays", whole=True)
    fan: bool = False


def test_a_declaration_is_default_parameter_and_check() -> None:
    heat, trays = Oven.parameters()
    assert (heat.name, heat.unit, heat.nominal, heat.high) == ("heat", "K", 300.0, 1000.0)
    assert trays.description == "number of trays"
    assert Oven() == Oven(heat=300.0, trays=2.0, fan=False)


def test_a_whole_number_is_as_good_as_a_float() -> None:
    oven = Oven(heat=500)
    assert oven == Oven(heat=500.0)
    assert isinstance(oven.heat, float)
    assert isinstance(Oven(heat=np.int64(500)).heat, float)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"heat": 1001.0}, "kitchen: Oven: heat = 1001 is outside its range 0 .. 1000 K"),
        ({"heat": float("nan")}, "kitchen: Oven: heat = nan is outside its range 0 .. 1000 K"),
        ({"heat": "hot"}, "kitchen: Oven: heat: 'hot' is not a number"),
        ({"heat": True}, "kitchen: Oven: heat: True is not a number"),
        ({"heat": 10**400}, "is too large"),
        ({"trays": 2.5}, "kitchen: Oven: trays = 2.5 must be a whole number"),
        ({"fan": "no"}, "kitchen: Oven: fan: 'no' is not true or false"),
        ({"tray": 2}, "kitchen: unknown key 'tray'; known are heat, trays, fan"),
    ],
)
def test_a_bad_value_gives_one_line_with_the_remedy(
    values: dict[str, object], message: str
) -> None:
    with pytest.raises(MicrogripperError) as error:
        Oven.from_values(values, "kitchen")
    assert message in str(error.value)
    assert "\n" not in str(error.value)
