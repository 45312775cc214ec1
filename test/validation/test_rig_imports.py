"""The rig stands by itself: what it imports of the package is the core's foundations alone."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

from microgripper_control import validation

ROOM = Path(validation.__file__).parent
ALLOWED = {
    *(
        f"microgripper_control.core.{name}"
        for name in ("compiled", "errors", "files", "parameters")
    ),
    "numpy",
    "scipy",
    "numba",
    "yaml",
}
OWN = "microgripper_control.validation"


def foreign(source: str) -> set[str]:
    """Modules imported anywhere in a source that the rig may not have."""
    modules = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            modules.add(str(node.module))
    return {
        module
        for module in modules
        if module.split(".")[0] not in sys.stdlib_module_names
        and module != OWN
        and not module.startswith(f"{OWN}.")
        and not any(module == name or module.startswith(f"{name}.") for name in ALLOWED)
    }


@pytest.mark.parametrize(
    "file", sorted(ROOM.rglob("*.py")), ids=lambda file: str(file.relative_to(ROOM))
)
def test_the_rig_imports_nothing_that_it_checks(file: Path) -> None:
    assert foreign(file.read_text(encoding="utf-8")) == set()


@pytest.mark.parametrize(
    "module", ["effects.base", "plant.model", "identification.fit", "control.pid", "core.recording"]
)
def test_a_foreign_import_is_found(module: str) -> None:
    assert foreign(f"def late():\n    from microgripper_control.{module} import x") != set()
