"""Models as YAML: what is written is what is read, and every fault is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.share import share_folder
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, Setting, nominal_model
from microgripper_control.plant.model_file import load_model, save_model

SOUND = """\
schema: microgripper-model/1
name: test rig
voltage: {low: -20.0, high: 150.0, unit: V}
nominal:
  bouc_wen:
    d: {value: 1.5e-7, unit: m/V}
    alpha: {value: 0.08, unit: "1"}
    beta: {value: 0.0152, unit: 1/(V*m^(n-1))}
    gamma: {value: -0.0227, unit: 1/(V*m^(n-1))}
    n: {value: 1, unit: "1"}
  second_order:
    m: {value: 0.0038, unit: kg}
    b: {value: 150, unit: N*s/m}
    k: {value: 5e7, unit: N/m}
    k_s: {value: 820000, unit: N/m}
effects:
  transport_delay:
    delay: {value: 0.001, unit: s}
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "rig.yaml"


def test_people_s_numbers_are_read(path: Path) -> None:
    path.write_text(SOUND, encoding="utf-8")
    model = load_model(path)
    assert model.name == "test rig"
    assert model.voltage_range == (-20.0, 150.0)
    assert model.value("second_order", "k") == 5e7  # YAML 1.1 takes it for text
    assert model.value("bouc_wen", "n") == 1.0
    assert model.effects == ("transport_delay",)


def test_every_link_comes_back_as_it_was(path: Path) -> None:
    model = nominal_model()
    for link in registry().values():
        if not link.nominal:
            model = model.with_link(link.name)
    model = model.with_settings(
        {
            ("bouc_wen", "d"): Setting(1.5e-7 / 3.0, (1e-8, 2e-7)),
            ("creep", "strength"): Setting(0.1, (-float("inf"), float("inf"))),
            ("second_order", "k"): Setting(4e7, frozen=True),
        }
    )
    save_model(model, path)
    assert load_model(path) == model
    first = path.read_bytes()
    save_model(load_model(path), path)
    assert path.read_bytes() == first


def test_a_description_and_a_foreign_name_come_back(path: Path) -> None:
    model = Model("Grëifer: #1", (0.0, 100.0), nominal_model().settings, "two\nlines")
    save_model(model, path)
    assert load_model(path) == model


def test_a_model_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(MicrogripperError, match=r"file/rig\.yaml: cannot be written"):
        save_model(nominal_model(), tmp_path / "file" / "rig.yaml")
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_the_paper_s_actuator_is_the_nominal_model() -> None:
    model = load_model(share_folder() / "config" / "apa120s.yaml")
    assert {name: model.values(name) for name in model.settings} == {
        name: nominal_model().values(name) for name in nominal_model().settings
    }


def without(line: str) -> str:
    assert line in SOUND
    return "".join(kept for kept in SOUND.splitlines(keepends=True) if line not in kept)


FAULTS = {
    "other schema": (SOUND.replace("model/1", "model/2"), "schema", "microgripper-model/1"),
    "no schema": (without("schema:"), "schema", "None", "microgripper-model/1"),
    "unknown top key": (SOUND + "voltages: {}\n", "'voltages'", "known are", "voltage"),
    "unknown link": (SOUND.replace("transport_delay", "delay_line"), "effects", "'delay_line'"),
    "wrong section": (
        SOUND.replace("effects:\n", "") + "effects: {bouc_wen: {}}\n",
        "transport_delay belongs under 'effects'",
    ),
    "nominal link as an effect": (
        without("transport_delay").replace("    delay: {value: 0.001, unit: s}\n", "")
        + "  bouc_wen: {}\n",
        "bouc_wen belongs under 'nominal'",
    ),
    "unknown parameter": (
        SOUND.replace("    n: ", "    nn: "),
        "nominal: bouc_wen",
        "'nn'",
        "known are d, alpha, beta, gamma, n",
    ),
    "missing parameter": (without("gamma:"), "bouc_wen", "gamma is missing", "allowed is"),
    "missing link": (SOUND[: SOUND.index("  second_order")], "second_order is missing"),
    "no unit": (SOUND.replace(", unit: kg", ""), "m: unit is missing", "unit: kg"),
    "other unit": (SOUND.replace("kg", "g"), "second_order: m: unit 'g'", "'kg'"),
    "no unit of voltage": (SOUND.replace(", unit: V", ""), "voltage", "unit: V"),
    "no value": (SOUND.replace("value: 0.0038, ", ""), "m: value", "None is not a finite number"),
    "unknown setting key": (SOUND.replace("0.0038,", "0.0038, std: 1,"), "m", "'std'", "frozen"),
    "text": (SOUND.replace("0.0038", "heavy"), "m: value", "'heavy' is not a finite number"),
    "a truth": (SOUND.replace("0.0038", "true"), "m: value", "True is not a finite number"),
    "a list": (SOUND.replace("0.0038", "[1]"), "m: value", "[1] is not a finite number"),
    "not a number": (SOUND.replace("0.0038", ".nan"), "m: value", "nan is not a finite number"),
    "infinite": (SOUND.replace("0.0038", ".inf"), "m: value", "inf is not a finite number"),
    "a huge whole number": (SOUND.replace("0.0038", "1" + "0" * 400), "m: value", "not a finite"),
    "out of range": (SOUND.replace("0.0038", "-1"), "second_order: m = -1", "1e-09 .. 1000 kg"),
    "effect out of range": (SOUND.replace("0.001", "7"), "transport_delay: delay = 7", "0 .. 1 s"),
    "empty range": (SOUND.replace("low: -20.0", "low: 150"), "voltage", "150 must be below high"),
    "levels the wrong way round": (
        SOUND + "  saturation: {low: {value: 150, unit: V}, high: {value: -20, unit: V}}\n",
        "effects: saturation: low 150 V must be below high -20 V",
    ),
    "half an interval": (SOUND.replace("0.0038,", "0.0038, low: 1,"), "m: high: None is not"),
    "an interval of text": (
        SOUND.replace("0.0038,", "0.0038, low: a, high: b,"),
        "m: low: 'a' is not",
    ),
    "frozen maybe": (SOUND.replace("0.0038,", "0.0038, frozen: 1,"), "m: frozen: 1", "true"),
    "a number for a parameter": (SOUND.replace("{value: 0.001, unit: s}", "1"), "delay", "found 1"),
    "a list for a link": (SOUND.replace("  transport_delay:\n", "  creep: []\n  x:\n"), "creep"),
    "a word": ("gripper\n", "expected keys with values", "'gripper'"),
    "nothing": ("", "expected keys with values", "None"),
    "broken YAML": (SOUND + "  ]\n", "not valid YAML", "line"),
    "an object": (SOUND + "x: !!python/object:os.system {}\n", "not valid YAML"),
    "bottomless nesting": ("[" * 5000, "not valid YAML"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_is_named_in_one_line(path: Path, fault: str) -> None:
    text, *words = FAULTS[fault]
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MicrogripperError) as caught:
        load_model(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_a_file_that_is_no_text_is_named(path: Path) -> None:
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(MicrogripperError, match=r"rig\.yaml: is not a text file"):
        load_model(path)


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match=r"none\.yaml: cannot be read: No such file"):
        load_model(tmp_path / "none.yaml")
    with pytest.raises(MicrogripperError, match="cannot be read: Is a directory"):
        load_model(tmp_path)


def test_a_part_of_an_effect_that_most_rigs_have_not_may_be_left_out(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text(SOUND, encoding="utf-8")
    assert load_model(tmp_path / "rig.yaml").value("transport_delay", "clock") == 0.0


def test_so_may_what_only_such_a_part_needs(tmp_path: Path) -> None:
    rigid = """
  contact:
    position: {value: 1.0e-05, unit: m}
    stiffness: {value: 2.0e+06, unit: N/m}
    exponent: {value: 1.0, unit: '1'}
    damping: {value: 0.0, unit: s/m}
    side: {value: 1.0, unit: '1'}
"""
    path = tmp_path / "rig.yaml"
    path.write_text(SOUND.rstrip() + rigid, encoding="utf-8")
    assert load_model(path).values("contact")["relaxing"] == 0.0
    soft = rigid + "    relaxing: {value: 1.0, unit: '1'}\n"
    path.write_text(SOUND.rstrip() + soft, encoding="utf-8")
    with pytest.raises(MicrogripperError, match=r"contact: .*stiffening"):
        load_model(path)


def test_a_file_from_before_an_effect_had_another_way_is_still_read(tmp_path: Path) -> None:
    """But not an effect of which nothing is said."""
    lopsided = """
  asymmetric_hysteresis:
    tilt: {value: 1.0e-09, unit: m/V}
    bulge: {value: 0.0, unit: m/V^2}
    twist: {value: 0.0, unit: m/V^3}
    skew: {value: 0.0, unit: m}
    reach: {value: 15.0, unit: V}
    delta: {value: 0.0, unit: m/V^2}
    beta: {value: 0.0152, unit: 1/V}
    gamma: {value: -0.0227, unit: 1/V}
"""
    path = tmp_path / "rig.yaml"
    path.write_text(SOUND.rstrip() + lopsided, encoding="utf-8")
    values = load_model(path).values("asymmetric_hysteresis")
    assert [values[name] for name in ("onward", "backward", "plays")] == [0.0, 0.0, 0.0]
    path.write_text(SOUND.rstrip() + "\n  sensor_zero: {}\n", encoding="utf-8")
    with pytest.raises(MicrogripperError, match=r"sensor_zero: offset is missing"):
        load_model(path)
