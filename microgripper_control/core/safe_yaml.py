"""YAML as plain data: numbers, texts, lists and mappings, and nothing that runs or explodes."""

from __future__ import annotations

from typing import Any

import yaml
from yaml.composer import ComposerError


class _PlainLoader(yaml.SafeLoader):
    """Refuses aliases: a few lines of them stand for gigabytes once they are printed or walked."""

    def compose_node(self, parent: Any, index: Any) -> Any:  # noqa: ANN401 (as in PyYAML)
        if self.check_event(yaml.AliasEvent):
            problem = "aliases (*NAME) are not read; write the value out"
            raise ComposerError(None, None, problem, self.get_mark())
        return super().compose_node(parent, index)


def load_yaml(text: str) -> object:
    """Parse YAML by PyYAML's safe loader; ValueError, in one line, on anything it does not allow.

    Tags that make Python objects are not allowed, nor are aliases.
    """
    try:
        loader = _PlainLoader(text)
        try:
            return loader.get_single_data()
        finally:
            loader.dispose()
    except RecursionError:
        raise ValueError("nested too deeply") from None
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as error:
        raise ValueError(" ".join(str(error).split())) from None
