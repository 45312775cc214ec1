"""The signal chain as a drawing, with the probability that the fault lies in each stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap

from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.effects.base import Stage
from microgripper_control.effects.registry import registry
from microgripper_control.report.markup import Html, element, joined
from microgripper_control.report.wording import listed, percent, plain

PARTS = {
    Stage.DRIVE: "amplifier",
    Stage.MATERIAL: "piezo stack",
    Stage.MECHANICS: "flexure, mass",
    Stage.TRANSMISSION: "joint, finger",
    Stage.SENSOR: "position gauge",
}
WIDTH, HEIGHT, APART = 128.0, 74.0, 30.0
ACROSS_END = 84.0  # room for the words at both ends
DOWN_END = 26.0
DOWN_HEIGHT, DOWN_WIDTH = 70.0, 176.0
LONGEST_LINE, LINE = 15, 15.0  # letters of an effect's name, and their height
SHARE_WIDTH = 42.0  # of a percentage


@dataclass(frozen=True)
class Place:
    """Where one stage is drawn, and what is said of it."""

    stage: Stage
    probability: float
    effects: tuple[str, ...]
    x: float
    y: float
    width: float
    height: float


def chain(diagnosis: Diagnosis) -> Html:
    """The chain, across on wide screens and down on narrow ones."""
    return element(
        "section",
        element("h2", "Where in the signal chain"),
        _across(diagnosis),
        _down(diagnosis),
        element(
            "p",
            "Percentages: probability that what is missing from the model acts there. "
            "Marked: where a diagnosed effect acts."
            if diagnosis.effects
            else "Percentages: probability that what is missing from the model acts there.",
            class_="note",
        ),
    )


def _guilty(diagnosis: Diagnosis, stage: Stage) -> tuple[str, ...]:
    known = registry()
    return tuple(e for e in diagnosis.effects if e in known and known[e].stage is stage)


def _places(diagnosis: Diagnosis, across: bool) -> list[Place]:
    places = []
    for index, stage in enumerate(Stage):
        size = (WIDTH, HEIGHT) if across else (DOWN_WIDTH, DOWN_HEIGHT)
        x = ACROSS_END + APART + index * (WIDTH + APART) if across else 20.0
        y = 6.0 if across else DOWN_END + APART + index * (DOWN_HEIGHT + APART)
        effects = _guilty(diagnosis, stage)
        probability = diagnosis.stages.get(stage.value, 0.0)
        places.append(Place(stage, probability, effects, x, y, *size))
    return places


def _across(diagnosis: Diagnosis) -> Html:
    places = _places(diagnosis, across=True)
    end = places[-1].x + WIDTH + APART
    middle = places[0].y + HEIGHT / 2.0
    arrows = [_arrow(p.x - APART, middle, p.x, middle) for p in places]
    arrows.append(_arrow(end - APART, middle, end, middle))
    lines = max(sum(len(wrap(plain(e), LONGEST_LINE)) for e in p.effects) for p in places)
    height = places[0].y + HEIGHT + 10.0 + LINE * lines
    words = [
        _text("voltage", ACROSS_END - 6.0, middle + 5.0, "end", "end"),
        _text("displacement", end + 6.0, middle + 5.0, "end", "start"),
    ]
    return _drawing(diagnosis, places, [*arrows, *words], end + ACROSS_END + 16.0, height, "across")


def _down(diagnosis: Diagnosis) -> Html:
    places = _places(diagnosis, across=False)
    middle = places[0].x + DOWN_WIDTH / 2.0
    end = places[-1].y + DOWN_HEIGHT + APART
    arrows = [_arrow(middle, p.y - APART, middle, p.y) for p in places]
    arrows.append(_arrow(middle, end - APART, middle, end))
    words = [
        _text("voltage", middle, DOWN_END - 6.0, "end", "middle"),
        _text("displacement", middle, end + 18.0, "end", "middle"),
    ]
    return _drawing(diagnosis, places, [*arrows, *words], 330.0, end + DOWN_END, "down")


def _drawing(
    diagnosis: Diagnosis,
    places: Sequence[Place],
    rest: Sequence[Html],
    width: float,
    height: float,
    kind: str,
) -> Html:
    told = ", ".join(f"{p.stage.value} {percent(p.probability)}" for p in places)
    guilty = f"; diagnosed: {listed(diagnosis.effects)}" if diagnosis.effects else ""
    return element(
        "svg",
        element("title", f"Signal chain with stage probabilities: {told}{guilty}"),
        joined(*rest),
        joined(*(_box(place, kind == "down") for place in places)),
        viewBox=f"0 0 {width:g} {height:g}",
        role="img",
        class_=f"chain {kind}",
    )


def _box(place: Place, beside: bool) -> Html:
    left, bottom = place.x + 12.0, place.y + place.height
    track = place.width - 24.0 - SHARE_WIDTH
    words = [line for effect in place.effects for line in wrap(plain(effect), LONGEST_LINE)]
    named = [
        _text(
            line,
            place.x + (place.width + 8.0 if beside else place.width / 2.0),
            place.y + 24.0 + LINE * row if beside else bottom + 18.0 + LINE * row,
            "guilty",
            "start" if beside else "middle",
        )
        for row, line in enumerate(words)
    ]
    return element(
        "g",
        element("rect", x=place.x, y=place.y, width=place.width, height=place.height, rx=6.0),
        _text(place.stage.value, left, place.y + 22.0, "stage", "start"),
        _text(PARTS[place.stage], left, place.y + 38.0, "part", "start"),
        _text(
            percent(place.probability), place.x + place.width - 10.0, bottom - 9.0, "share", "end"
        ),
        element("rect", x=left, y=bottom - 17.0, width=track, height=5.0, class_="track"),
        element(
            "rect",
            x=left,
            y=bottom - 17.0,
            width=track * min(max(place.probability, 0.0), 1.0),
            height=5.0,
            class_="fill",
        ),
        joined(*named),
        class_="box marked" if place.effects else "box",
    )


def _arrow(x1: float, y1: float, x2: float, y2: float) -> Html:
    """A line with a head; it ends a little before what it points at."""
    across = y1 == y2
    tip = (x2 - 3.0, y2) if across else (x2, y2 - 3.0)
    back = ((-8.0, -4.5), (-8.0, 4.5)) if across else ((-4.5, -8.0), (4.5, -8.0))
    corners = [tip, *((tip[0] + dx, tip[1] + dy) for dx, dy in back)]
    head = f"M{'L'.join(f'{x:g} {y:g}' for x, y in corners)}Z"
    start = (x1 + 3.0, y1) if across else (x1, y1 + 3.0)
    line = element("line", x1=start[0], y1=start[1], x2=tip[0], y2=tip[1])
    return element("g", line, element("path", d=head), class_="arrow")


def _text(content: str, x: float, y: float, kind: str, anchor: str) -> Html:
    return element("text", content, x=x, y=y, class_=kind, text_anchor=anchor)
