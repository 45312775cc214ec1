from __future__ import annotations

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.mapping import Mapping, Source


@pytest.mark.parametrize(
    ("text", "source"),
    [
        ("voltage=force_N", Source("force_N")),
        ("voltage=u [V]*20", Source("u [V]", None, 20.0)),
        ("voltage=/amp/out", Source("/amp/out")),
        ("voltage=/amp/out:data", Source("/amp/out", "data")),
        (
            "voltage=/rig/joint_states:position[0]*1e-6",
            Source("/rig/joint_states", "position[0]", 1e-6),
        ),
        ("voltage=/ati:wrench.force.z*-0.5", Source("/ati", "wrench.force.z", -0.5)),
        ("voltage= drive : data * 2 ", Source("drive : data", None, 2.0)),
        ("voltage=Channel 1: U (V)", Source("Channel 1: U (V)")),
    ],
)
def test_a_source(text: str, source: Source) -> None:
    assert Mapping.parse([text]) == Mapping(voltage=source)


def test_all_quantities_at_once() -> None:
    found = Mapping.parse(["time=t*1e-3", "displacement=x", "setpoint=r", "voltage=u"])
    assert found == Mapping(Source("u"), Source("x"), Source("r"), Source("t", None, 1e-3))
    assert Mapping.parse([]) == Mapping()


def test_a_colon_belongs_to_the_name_of_a_column() -> None:
    source = Mapping.parse(["voltage=ch1:u*3"]).voltage
    assert source is not None
    assert (source.name, source.field, source.column) == ("ch1", "u", "ch1:u")


@pytest.mark.parametrize(
    ("texts", "complaint"),
    [
        (["voltage"], "--map voltage: expected QUANTITY="),
        (["volts=u"], "unknown quantity 'volts'; known are voltage, displacement"),
        (["voltage=u", "voltage=w"], "voltage is mapped twice"),
        (["voltage="], "no column or topic is named"),
        (["voltage=*3"], "no column or topic is named"),
        (["voltage=u*three"], "scale 'three' is not a number"),
        (["voltage=u*nan"], "scale nan must be finite"),
        (["voltage=u*0"], "must be finite and not 0"),
        (["voltage=/joint_states:position[x]"], "the field is not of the form"),
    ],
)
def test_a_bad_mapping_is_quoted(texts: list[str], complaint: str) -> None:
    with pytest.raises(MicrogripperError) as caught:
        Mapping.parse(texts)
    assert complaint in str(caught.value)
    assert f"--map {texts[-1]}" in str(caught.value)
