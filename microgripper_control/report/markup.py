"""HTML and SVG put together from elements, so that every text is escaped by construction."""

from __future__ import annotations

from html import escape


class Html(str):
    """Text that is markup already; any other text is escaped where it is put into an element."""

    __slots__ = ()


Child = str | None  # Html, or plain text; None is left out
VOID = frozenset({"br", "col", "link", "meta"})


def joined(*children: Child) -> Html:
    """Children one after the other."""
    given = (child for child in children if child is not None)
    return Html("".join(c if isinstance(c, Html) else escape(c) for c in given))


def element(name: str, /, *children: Child, **attributes: str | float | bool | None) -> Html:
    """An element with its children.

    In the attributes' names `_` stands for `-` and one at the end is dropped (`class_`); True gives
    an attribute without a value, False and None leave it out, numbers have six digits.
    """
    parts = [name]
    for key, value in attributes.items():
        key = key.rstrip("_").replace("_", "-")
        if value is True:
            parts.append(key)
        elif value is not None and value is not False:
            text = value if isinstance(value, str) else f"{value:.6g}"
            parts.append(f'{key}="{escape(text)}"')
    opened = f"<{' '.join(parts)}>"
    return Html(opened if name in VOID else f"{opened}{joined(*children)}</{name}>")
