"""Models as YAML files, every number with its unit.

schema: microgripper-model/1
name: APA120S
voltage: {low: 0.0, high: 160.0, unit: V}
nominal:
  bouc_wen:
    d: {value: 1.4447e-07, unit: m/V}
    ...
effects:
  transport_delay:
    delay: {value: 0.001, unit: s}
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import written_whole
from microgripper_control.core.safe_yaml import load_yaml
from microgripper_control.effects.base import Link
from microgripper_control.effects.registry import link_named, registry
from microgripper_control.plant.model import Model, Setting

SCHEMA = "microgripper-model/1"
TOP_KEYS = ("schema", "name", "description", "voltage", "nominal", "effects")
SETTING_KEYS = ("value", "unit", "low", "high", "frozen")


def load_model(path: str | Path) -> Model:
    """Read a model; MicrogripperError names the file, the key and the remedy."""
    path = Path(path)
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise MicrogripperError(f"{path}: is not a text file; a model is YAML") from None
    except ValueError as error:
        raise MicrogripperError(f"{path}: is not valid YAML: {error}") from None
    return parse_model(content, str(path))


def parse_model(content: object, origin: str) -> Model:
    """Make a model of parsed YAML; `origin` is what error messages call it."""
    top = _mapping(content, origin, TOP_KEYS)
    if top.get("schema") != SCHEMA:
        raise MicrogripperError(f"{origin}: schema: {top.get('schema')!r}; expected {SCHEMA!r}")
    settings: dict[str, dict[str, Setting]] = {}
    for section, nominal in (("nominal", True), ("effects", False)):
        where = f"{origin}: {section}"
        for name, given in _mapping(top.get(section) or {}, where).items():
            link = link_named(str(name), where)
            if link.nominal != nominal:
                other = "nominal" if link.nominal else "effects"
                raise MicrogripperError(f"{where}: {name} belongs under {other!r}")
            settings[link.name] = _link_settings(given, f"{where}: {name}", link)
    voltage = _mapping(top.get("voltage"), f"{origin}: voltage", ("low", "high", "unit"))
    _check_unit(voltage, "V", f"{origin}: voltage")
    low, high = (_number(voltage.get(key), f"{origin}: voltage: {key}") for key in ("low", "high"))
    return Model(
        name=str(top.get("name", Path(origin).stem)),
        voltage_range=(low, high),
        settings=settings,
        description=str(top.get("description", "")),
        origin=origin,
    )


def save_model(model: Model, path: str | Path) -> None:
    """Write a model; the file appears whole or not at all."""
    text = yaml.safe_dump(
        _plain(model), sort_keys=False, allow_unicode=True, width=100, default_flow_style=None
    )
    with written_whole(path) as file:
        file.write(text)


def _plain(model: Model) -> dict[str, Any]:
    sections: dict[str, dict[str, Any]] = {"nominal": {}, "effects": {}}
    for name, settings in model.settings.items():
        link = registry()[name]
        section = sections["nominal" if link.nominal else "effects"]
        section[name] = {
            key: _plain_setting(setting, link.parameter(key).unit)
            for key, setting in settings.items()
        }
    low, high = model.voltage_range
    head: dict[str, Any] = {"schema": SCHEMA, "name": model.name}
    if model.description:
        head["description"] = model.description
    return {**head, "voltage": {"low": low, "high": high, "unit": "V"}, **sections}


def _plain_setting(setting: Setting, unit: str) -> dict[str, Any]:
    plain: dict[str, Any] = {"value": float(setting.value), "unit": unit}
    if setting.interval is not None:
        plain["low"], plain["high"] = map(float, setting.interval)
    if setting.frozen:
        plain["frozen"] = True
    return plain


def _link_settings(given: object, where: str, link: Link) -> dict[str, Setting]:
    """What an effect is nominally without may be left out, and what only such a part needs.

    A sensor's clock is one; how an object relaxes that does not is another. How strong the effect
    is has to be said by one parameter at least.
    """
    known = tuple(p.name for p in link.parameters)
    found = {
        name: _setting(entry, f"{where}: {name}", link.parameter(name).unit)
        for name, entry in _mapping(given, where, known).items()
    }
    values = {p.name: p.nominal for p in link.parameters}
    values |= {name: setting.value for name, setting in found.items()}
    if why := link.nonsense(values):
        raise MicrogripperError(f"{where}: {why}")
    unused = link.idle(values)
    strong = any(link.parameter(name).vanishing is not None for name in found)
    for p in link.parameters:
        without = p.nominal == 0.0 and (strong or p.vanishing is None)
        if p.name not in found and (without or p.name in unused):
            found[p.name] = Setting(p.nominal)
    return found


def _setting(entry: object, where: str, unit: str) -> Setting:
    given = _mapping(entry, where, SETTING_KEYS)
    _check_unit(given, unit, where)
    interval = None
    if "low" in given or "high" in given:
        low, high = (_number(given.get(key), f"{where}: {key}", True) for key in ("low", "high"))
        interval = low, high
    frozen = given.get("frozen", False)
    if not isinstance(frozen, bool):
        raise MicrogripperError(f"{where}: frozen: {frozen!r}; expected true or false")
    return Setting(_number(given.get("value"), f"{where}: value"), interval, frozen)


def _mapping(given: object, where: str, known: tuple[str, ...] = ()) -> Mapping[str, Any]:
    if not isinstance(given, dict):
        raise MicrogripperError(f"{where}: expected keys with values, found {given!r:.60}")
    for key in given:
        if known and key not in known:
            raise MicrogripperError(f"{where}: unknown key {key!r}; known are {', '.join(known)}")
    return given


def _check_unit(given: Mapping[str, Any], unit: str, where: str) -> None:
    found = given.get("unit")
    if found is None:
        raise MicrogripperError(f"{where}: unit is missing; add unit: {unit}")
    if str(found) != unit:
        raise MicrogripperError(f"{where}: unit {found!r}; expected {unit!r}")


def _number(given: object, where: str, infinite: bool = False) -> float:
    """A number; YAML 1.1 reads `5e7` as text, people mean a number."""
    try:
        if isinstance(given, bool) or not isinstance(given, (int, float, str)):
            raise ValueError
        value = float(given)
        if value != value or (not infinite and value in (float("inf"), -float("inf"))):
            raise ValueError
    except (ValueError, OverflowError):
        raise MicrogripperError(f"{where}: {given!r:.60} is not a finite number") from None
    return value
