"""Files of other people are data: nothing in them is run, and nothing of them leads elsewhere."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import microgripper_control

PACKAGE = Path(microgripper_control.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
YAML_READER = PACKAGE / "core" / "safe_yaml.py"

RUNNING_MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "marshal", "shelve", "code", "pty"}
RUNNING_BUILTINS = {"eval", "exec", "compile", "__import__"}
RUNNING_CALLS = {"os.system", "os.popen", "joblib.load", "numpy.load", "np.load", "torch.load"}
WRITING_YAML = {"safe_dump"}


def faults(source: str) -> list[str]:
    """What of a source could run something that it reads."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = {str(node.module).split(".")[0]}
            if node.module == "yaml":
                found.append("from yaml import ...")
        else:
            names = set()
        found += sorted(names & RUNNING_MODULES)
        if isinstance(node, ast.Attribute):
            name = ast.unparse(node)
            if name in RUNNING_CALLS or (
                name.startswith("yaml.") and node.attr not in WRITING_YAML
            ):
                found.append(name)
        if isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in RUNNING_BUILTINS:
                found.append(node.func.id)
            found += [
                f"{given.arg}=True"
                for given in node.keywords
                if given.arg in {"shell", "allow_pickle"}
                and not (isinstance(given.value, ast.Constant) and given.value.value is False)
            ]
    return found


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(PACKAGE)))
def test_nothing_that_is_read_is_run(file: Path) -> None:
    found = faults(file.read_text(encoding="utf-8"))
    if file == YAML_READER:
        found = [one for one in found if one not in KNOWN_IN_THE_READER]
    assert found == []


KNOWN_IN_THE_READER = {  # `yaml.parse` names what is written; it makes nothing of it
    "yaml.SafeLoader",
    "yaml.parse",
    "yaml.AliasEvent",
    "yaml.CollectionStartEvent",
    "yaml.CollectionEndEvent",
    "yaml.YAMLError",
    *(f"yaml.{kind}" for kind in ("Node", "MappingNode", "ScalarNode", "SequenceNode")),
}


@pytest.mark.parametrize(
    "source",
    [
        "import pickle",
        "def f():\n    from marshal import loads",
        "yaml.load(text, yaml.SafeLoader)",
        "yaml.safe_load(text)",
        "from yaml import load",
        "eval(text)",
        "np.load(path)",
        "subprocess.run(text, shell=True)",
        "os.system(text)",
    ],
)
def test_what_could_run_is_found(source: str) -> None:
    assert faults(source)


def test_the_pages_scripts_write_text_and_no_markup() -> None:
    assets = sorted((PACKAGE / "report" / "assets").glob("*.js"))
    assert assets
    markup = re.compile(
        r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|Function\("
    )
    for asset in assets:
        assert not markup.search(asset.read_text(encoding="utf-8")), asset.name
