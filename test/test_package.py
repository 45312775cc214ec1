"""package.xml, setup.py and the code say the same of the package."""

from __future__ import annotations

import ast
import re
import runpy
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]

# Where rosdep's name is not python3- and the name in the Python package index.
ROSDEP_KEYS = {
    "control": "python-control-pip",
    "PyYAML": "python3-yaml",
    "rosbags": "python3-rosbags-pip",
    "ruff": "python3-ruff-pip",
    "types-PyYAML": "python3-types-pyyaml",
}
SUFFIXES = {".yaml", ".xml", ".py"}  # of configuration and launch files
WITHOUT_WHEELS = {"launch", "launch_ros"}  # needed by launch/ alone, which needs a ROS 2


@pytest.fixture
def setup_arguments(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What setup.py hands to setuptools, which need not be installed."""
    arguments: dict[str, Any] = {}
    stand_in = SimpleNamespace(setup=arguments.update, find_packages=lambda include: include)
    monkeypatch.setitem(sys.modules, "setuptools", stand_in)
    monkeypatch.chdir(ROOT)
    runpy.run_path("setup.py")
    return arguments


@pytest.fixture
def manifest() -> ElementTree.Element:
    return ElementTree.parse(ROOT / "package.xml").getroot()


def rosdep_keys(requirements: list[str]) -> set[str]:
    """The names that rosdep and ROS have for packages of the Python package index."""
    names = [re.split(r"[<>=~!]", requirement)[0] for requirement in requirements]
    return {
        name.removeprefix("ros-jazzy-").replace("-", "_")
        if name.startswith("ros-jazzy-")
        else ROSDEP_KEYS.get(name, f"python3-{name}")
        for name in names
    }


def texts(manifest: ElementTree.Element, tag: str) -> set[str]:
    return {element.text or "" for element in manifest.iterfind(tag)}


def test_both_files_describe_the_same_package(
    setup_arguments: dict[str, Any], manifest: ElementTree.Element
) -> None:
    for key in ("name", "version", "description", "license"):
        assert manifest.findtext(key) == setup_arguments[key]
    assert manifest.findtext("maintainer") == setup_arguments["author"]


def test_both_files_name_the_same_dependencies(
    setup_arguments: dict[str, Any], manifest: ElementTree.Element
) -> None:
    extras = setup_arguments["extras_require"]
    needed = rosdep_keys(setup_arguments["install_requires"] + extras["ros"])
    assert texts(manifest, "exec_depend") == needed | WITHOUT_WHEELS
    assert texts(manifest, "test_depend") == rosdep_keys(extras["test"])


def test_the_wheels_of_ros_are_pinned(setup_arguments: dict[str, Any]) -> None:
    for requirement in setup_arguments["extras_require"]["ros"]:
        assert re.fullmatch(r"ros-jazzy-[a-z-]+==[0-9.]+", requirement)


def test_everything_imported_is_a_declared_dependency(setup_arguments: dict[str, Any]) -> None:
    extras = setup_arguments["extras_require"]
    declared = setup_arguments["install_requires"] + extras["ros"] + extras["cluster"]
    known = {re.sub("^python3?-|-pip$", "", key) for key in rosdep_keys(declared)}
    assert "numba" in known
    known.add("llvmlite")  # a part of numba, which alone knows the version that fits
    imported: set[str] = set()
    for file in (ROOT / "microgripper_control").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(str(node.module).split(".")[0])
    assert imported - set(sys.stdlib_module_names) - {"microgripper_control"} <= known


def test_all_configuration_and_launch_files_are_installed(setup_arguments: dict[str, Any]) -> None:
    installed = {path for _, paths in setup_arguments["data_files"] for path in paths}
    for folder in ("config", "launch"):
        files = {path for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES}
        assert {str(path.relative_to(ROOT)) for path in files} <= installed


def test_all_files_beside_the_code_are_installed(setup_arguments: dict[str, Any]) -> None:
    package = ROOT / "microgripper_control"
    patterns = setup_arguments["package_data"]["microgripper_control"]
    installed = {file for pattern in patterns for file in package.glob(pattern)}
    beside = {f for f in package.rglob("*") if f.is_file() and f.suffix not in {".py", ".pyc"}}
    assert beside <= installed


def test_every_executable_exists(setup_arguments: dict[str, Any]) -> None:
    for entry in setup_arguments["entry_points"]["console_scripts"]:
        name, module, function = re.split(r" = |:", entry)
        file = ROOT / f"{module.replace('.', '/')}.py"
        assert file.is_file(), f"{name}: no {file.relative_to(ROOT)}"
        functions = ast.parse(file.read_text(encoding="utf-8")).body
        assert function in {f.name for f in functions if isinstance(f, ast.FunctionDef)}, name
