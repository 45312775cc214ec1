"""Names from bags, CSV and model files are text on every page, whatever they say."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from diagnoses import creeping

from microgripper_control.core.recording import Recording
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import load_model, save_model
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.bag_writer import BagWriter
from microgripper_control.recordings.csv import write_csv
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag
from microgripper_control.report.demo_page import Chapter, Shown, write_demo_page
from microgripper_control.report.diagnosis_page import write_diagnosis_report

SCRIPT = "</script><script>alert(1)</script>"
IMAGE = "\"'><img src=x onerror=alert(1)>&amp;"
HOSTILE = SCRIPT + IMAGE
IN_A_PATH = HOSTILE.replace("/", "\u2215")  # looks the same and is allowed


class Tags(HTMLParser):
    """The elements of a page, and all text outside of scripts."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.attributes: list[str] = []
        self.text = ""
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_data(self, data: str) -> None:
        self.text += data


def check(page: Path, harmless: Path) -> None:
    """The hostile page has the elements of the harmless one."""
    found, expected = Tags(page), Tags(harmless)
    assert found.seen.count("script") == expected.seen.count("script")
    assert "img" not in found.seen or "img" in expected.seen
    assert not [name for name in found.attributes if name.startswith("on")]


@pytest.fixture
def recordings(tmp_path: Path) -> list[Recording]:
    """A bag and a CSV in which every name is hostile."""
    made = creeping(("run",), samples=500).judged[0].recording
    write_bag(tmp_path / "plain", made)
    path = tmp_path / f"bag{IN_A_PATH}"
    with Bag(tmp_path / "plain") as plain, BagWriter(path) as writer:
        (topic,) = plain.topics
        writer.add_topic(f"/{HOSTILE}/joint_states", topic.type)
        writer.add_topic(f"/{HOSTILE}/setpoint", "std_msgs/msg/Float64")
        for _, at, content in plain.messages([topic]):
            writer.write(f"/{HOSTILE}/joint_states", at, content)
    metadata = path / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("message_count: 0", "message_count: 7"))

    csv = tmp_path / f"csv{IN_A_PATH}.csv"
    write_csv(csv, made)
    csv.write_text(csv.read_text().replace("voltage_V", f"volt{SCRIPT}"))
    found = [read_recording(path), read_recording(csv, Mapping.parse([f"voltage=volt{SCRIPT}"]))]
    assert HOSTILE in "".join(found[0].warnings)
    return found


def test_the_diagnosis(tmp_path: Path, recordings: list[Recording]) -> None:
    save_model(nominal_model(), tmp_path / "model.yaml")
    text = (tmp_path / "model.yaml").read_text()
    named = re.sub("(?m)^name: .*$", f"name: {json.dumps(HOSTILE)}", text)
    (tmp_path / "model.yaml").write_text(f"{named}\ndescription: {json.dumps(HOSTILE)}\n")
    model = load_model(tmp_path / "model.yaml")
    assert HOSTILE in (model.name, model.description)

    found = creeping(("run", "again"), samples=500)
    judged = tuple(
        replace(one, recording=recording)
        for one, recording in zip(found.judged, recordings, strict=True)
    )
    warnings = tuple(f"{one.name}: {text}" for one in recordings for text in one.warnings)
    hostile = replace(
        found, judged=judged, warnings=warnings, nominal=model,
        model=replace(found.model, name=model.name, description=model.description),
    )  # fmt: skip
    write_diagnosis_report(found, tmp_path / "harmless.html")
    write_diagnosis_report(hostile, tmp_path / "report.html")
    check(tmp_path / "report.html", tmp_path / "harmless.html")
    assert HOSTILE in Tags(tmp_path / "report.html").text
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    (data,) = re.findall(r'id="report-data">(.*?)</script>', page, re.DOTALL)
    assert not set("<>&") & set(data)
    assert len(json.loads(data)["recordings"]) == 2


def test_the_pages_of_demo_paper_and_validation(tmp_path: Path) -> None:
    """They are all made by `Page`; the demo's has each kind of part."""

    def write(name: str, text: str) -> Path:
        table = Shown(text, (text, text), [(text, text)])
        chapter = Chapter(text, [text], [table], [], [text], (text, text))
        write_demo_page(tmp_path / name, [chapter])
        return tmp_path / name

    check(write("hostile.html", HOSTILE), write("harmless.html", "harmless"))
    assert HOSTILE in Tags(tmp_path / "hostile.html").text
