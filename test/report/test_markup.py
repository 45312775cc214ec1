"""Text is escaped, markup is not escaped twice."""

from __future__ import annotations

from microgripper_control.report.markup import element, joined

HOSTILE = "\"><script>alert('bag')</script>&"


def test_text_is_escaped_in_content_and_in_attributes() -> None:
    made = element("p", HOSTILE, title=HOSTILE)
    assert "<script" not in made
    assert made.count("&lt;script&gt;") == 2
    assert made.count("&quot;") == 2


def test_elements_nest_without_being_escaped_again() -> None:
    assert element("p", element("b", "a < b"), None) == "<p><b>a &lt; b</b></p>"
    assert joined("&", element("br")) == "&amp;<br>"


def test_names_and_values_of_attributes() -> None:
    made = element("td", class_="number", data_of="x", open=True, hidden=False, x=1.0 / 3.0)
    assert made == '<td class="number" data-of="x" open x="0.333333"></td>'
