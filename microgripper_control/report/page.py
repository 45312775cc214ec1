"""A self-contained HTML page of paragraphs, tables and figures, for screen, phone and print.

Every text is escaped: names and messages may come from somebody's recording.
"""

from __future__ import annotations

import base64
from collections.abc import Collection, Iterable, Sequence
from html import escape
from pathlib import Path

from microgripper_control.core.files import written_whole

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1c2733; max-width: 60rem;
       margin: 0 auto; padding: 1rem; overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { font-size: 1.2rem; margin-top: 2rem; }
h3 { font-size: 1rem; margin: 1.4rem 0 0; }
.scroll { overflow-x: auto; overflow-wrap: normal; }
table { border-collapse: collapse; margin: .8rem 0; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .3rem .8rem; border-bottom: 1px solid #d8dee6; }
td { white-space: nowrap; }
.text { text-align: left; white-space: normal; }
td.text:first-child { white-space: nowrap; }
li { margin: .3rem 0; }
th { border-bottom: 2px solid #7b8794; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; }
figcaption, .note { color: #51606f; font-size: .9rem; }
@media print {
  body { max-width: none; padding: 0; font-size: 11pt; }
  figure, tr { break-inside: avoid; } h2, h3 { break-after: avoid; }
  .scroll { overflow: visible; } table { font-size: 8pt; } th, td { padding: .2rem .4rem; }
  td, td.text:first-child { white-space: normal; }
  td.text { overflow-wrap: anywhere; min-width: 6em; }
}
"""


class Page:
    """Collects the parts of a page in the order in which they are added."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._parts: list[str] = []

    def heading(self, text: str) -> None:
        """Begin a section."""
        self._parts.append(f"<h2>{escape(text)}</h2>")

    def caption(self, text: str) -> None:
        """Name the table or figure that follows."""
        self._parts.append(f"<h3>{escape(text)}</h3>")

    def paragraph(self, text: str) -> None:
        """Add a paragraph of plain text."""
        self._parts.append(f"<p>{escape(text)}</p>")

    def link(self, text: str, address: str) -> None:
        """Add a paragraph that leads to another file."""
        self._parts.append(f'<p><a href="{escape(address)}">{escape(text)}</a></p>')

    def points(self, texts: Iterable[str]) -> None:
        """Add a list of plain texts."""
        items = "".join(f"<li>{escape(text)}</li>" for text in texts)
        self._parts.append(f"<ul>{items}</ul>")

    def note(self, text: str) -> None:
        """Add a paragraph in small grey type."""
        self._parts.append(f'<p class="note">{escape(text)}</p>')

    def table(
        self, header: Sequence[str], rows: Iterable[Sequence[str]], texts: Collection[int] = (0,)
    ) -> None:
        """Add a table; the columns `texts` are text, the others are numbers, already formatted."""

        def row(tag: str, cells: Sequence[str]) -> str:
            kinds = (' class="text"' if i in texts else "" for i in range(len(cells)))
            marked = zip(kinds, map(escape, cells), strict=True)
            return "".join(f"<{tag}{kind}>{cell}</{tag}>" for kind, cell in marked)

        head = row("th", header)
        body = "".join(f"<tr>{row('td', cells)}</tr>" for cells in rows)
        self._parts.append(
            f'<div class="scroll"><table><thead><tr>{head}</tr></thead>'
            f"<tbody>{body}</tbody></table></div>"
        )

    def figure(self, png: Path, caption: str) -> None:
        """Embed a PNG file, so that the page can be sent on alone."""
        data = base64.b64encode(png.read_bytes()).decode()
        text = escape(caption)
        self._parts.append(
            f'<figure><img src="data:image/png;base64,{data}" alt="{text}">'
            f"<figcaption>{text}</figcaption></figure>"
        )

    def write(self, path: Path) -> None:
        """Write the page; it appears whole or not at all."""
        title, parts = escape(self._title), "\n".join(self._parts)
        with written_whole(path) as file:
            file.write(
                '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
                '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
                f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
                f"<h1>{title}</h1>\n{parts}\n</body>\n</html>\n"
            )
