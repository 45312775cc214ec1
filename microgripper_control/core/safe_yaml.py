"""YAML as plain data: numbers, texts, lists and mappings, and nothing that runs or explodes."""

from __future__ import annotations

from typing import Any

import yaml

# The one in C, where PyYAML was built with it, takes a tenth of the time.
LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
DEEPEST = 100  # lists and mappings inside each other


def load_yaml(text: str) -> object:
    """Parse YAML by PyYAML's safe loader; ValueError, in one line, on anything it does not allow.

    Tags that make Python objects are not allowed, nor are aliases: a few lines of them stand for
    gigabytes once they are printed or walked.
    """
    try:
        _refuse_what_explodes(text)
        loader = LOADER(text)
        try:
            node = loader.get_single_node()
            if node is None:
                return None
            _refuse_what_is_given_twice(node)
            return loader.construct_document(node)
        finally:
            loader.dispose()
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as error:
        raise ValueError(" ".join(str(error).split())) from None


def _refuse_what_is_given_twice(node: yaml.Node) -> None:
    """PyYAML keeps the last of two values in silence."""
    children = [node]
    while children:
        one = children.pop()
        if isinstance(one, yaml.MappingNode):
            seen = set()
            for key, value in one.value:
                children.append(value)
                if not isinstance(key, yaml.ScalarNode):
                    continue  # is no key of plain data: told where it is made
                if key.value in seen:
                    line = key.start_mark.line + 1 if key.start_mark else 1
                    raise ValueError(f"line {line}: {key.value!r} is given twice; remove one")
                seen.add(key.value)
        elif isinstance(one, yaml.SequenceNode):
            children += one.value


def _refuse_what_explodes(text: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=LOADER):
        if isinstance(event, yaml.AliasEvent):
            line = event.start_mark.line + 1 if event.start_mark else 1
            raise ValueError(f"line {line}: aliases (*NAME) are not read; write the value out")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ValueError("nested too deeply")
