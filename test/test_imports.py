"""Imports point one way."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import microgripper_control

PACKAGE = Path(microgripper_control.__file__).parent
NAME = PACKAGE.name

# Each room and the rooms it may import from, besides itself.
ROOMS: dict[str, set[str]] = {
    "core": set(),
    "effects": {"core"},
    "plant": {"core", "effects"},
    "control": {"core", "effects"},
    "recordings": {"core"},
    "identification": {"core", "effects", "plant"},
    "diagnosis": {"core", "effects", "plant", "identification"},
    "demo": {"core", "effects", "plant", "control", "identification", "recordings"},
    "paper": {"core", "effects", "plant", "control", "identification"},
    "validation": {"core"},  # a rig of its own: it shares nothing with what it checks
}
ROOMS["examination"] = {*ROOMS}
ROOMS["bench"] = {*ROOMS}
ROOMS["report"] = {*ROOMS}
ROOMS["nodes"] = {*ROOMS}
ROOMS["cli"] = {*ROOMS} - {"nodes"}

# The same within the diagnosis; what lies in none of these may import all of them.
DIAGNOSIS: dict[str, set[str]] = {
    "data": set(),
    "fits": {"data"},
    "signs": {"data"},
    "search": {"data", "fits", "signs"},
    "experiments": {"fits"},
    "answers": {"data", "fits", "signs", "search"},
}

# Each of these is imported in one room alone.
HOMES = {
    "control": "paper",  # python-control: slow to import
    "matplotlib": "report",
    "rosbags": "recordings",
    "builtin_interfaces": "nodes",
    "diagnostic_msgs": "nodes",
    "lifecycle_msgs": "nodes",
    "rcl_interfaces": "nodes",
    "rclpy": "nodes",
    "rosgraph_msgs": "nodes",
    "sensor_msgs": "nodes",
    "std_msgs": "nodes",
    "std_srvs": "nodes",
}


def imported_modules(source: str) -> set[str]:
    """Full names of all that is imported, at the top or inside a function."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports hide the room they come from"
            assert node.module is not None
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def faults(room: str, source: str) -> list[str]:
    """Imports that a file of the room may not have."""
    found = []
    for module in sorted(imported_modules(source)):
        top, *rest = module.split(".")
        if top == NAME and rest[0] in ROOMS and rest[0] not in {room, *ROOMS[room]}:
            found.append(f"{room} imports {module}")
        if HOMES.get(top, room) != room:
            found.append(f"{top} belongs to {HOMES[top]} alone")
    return found


def steps_back(part: str, source: str) -> list[str]:
    """Imports that a file of a part of the diagnosis may not have."""
    known = (module.split(".") for module in sorted(imported_modules(source)))
    inside = (rest[1:] for rest in known if rest[:2] == [NAME, "diagnosis"])
    parts = (rest[1] for rest in inside if len(rest) > 1 and rest[1] in DIAGNOSIS)
    return [f"{part} imports {other}" for other in parts if other not in {part, *DIAGNOSIS[part]}]


@pytest.mark.parametrize(
    "file",
    sorted(PACKAGE.glob("*/**/*.py")),
    ids=lambda file: str(file.relative_to(PACKAGE)),
)
def test_imports_point_one_way(file: Path) -> None:
    assert faults(file.relative_to(PACKAGE).parts[0], file.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("part", sorted(DIAGNOSIS))
def test_a_diagnosis_goes_one_way(part: str) -> None:
    files = sorted((PACKAGE / "diagnosis" / part).glob("*.py"))
    assert len(files) > 1
    for file in files:
        assert steps_back(part, file.read_text(encoding="utf-8")) == []


def test_a_step_back_is_found() -> None:
    source = f"from {NAME}.diagnosis.search.pool import Pool"
    assert steps_back("fits", source) == ["fits imports search"]
    assert steps_back("answers", source) == []


def test_every_room_has_its_place() -> None:
    assert {folder.parent.name for folder in PACKAGE.glob("diagnosis/*/__init__.py")} == {
        *DIAGNOSIS
    }
    assert {folder.parent.name for folder in PACKAGE.glob("*/__init__.py")} <= ROOMS.keys()


@pytest.mark.parametrize(
    ("room", "source"),
    [
        ("control", f"from {NAME}.plant.model import Model"),
        ("control", f"from {NAME} import plant"),
        ("plant", f"def late():\n    import {NAME}.identification.fit"),
        ("core", f"import numpy, {NAME}.effects"),
        ("cli", "import rclpy.node"),
        ("identification", "from rosbags.highlevel import AnyReader"),
        ("validation", f"from {NAME}.effects.registry import registry"),
        ("identification", f"from {NAME}.validation.case import make_case"),
    ],
)
def test_a_wrong_import_is_found(room: str, source: str) -> None:
    assert len(faults(room, source)) == 1
