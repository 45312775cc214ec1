"""The report is whole and self-contained, and a real browser draws every figure of it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import POLICY, Elements, framed, needs_browser, run, shown, with_script
from diagnoses import creeping, parameters_only

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.diagnosis.findings import UNKNOWN, Range
from microgripper_control.report.diagnosis_figures import recording_figures
from microgripper_control.report.diagnosis_layers import gap_bands
from microgripper_control.report.diagnosis_page import FIGURES, write_diagnosis_report
from microgripper_control.report.diagnosis_places import REACH
from microgripper_control.report.wording import MINUS

HOSTILE = "</script><script>document.title='taken'</script><img src=x onerror=alert(1)>&\"'"
LARGEST = 3e6  # bytes
LONG = "/recordings/" + "a_rig_with_a_name_that_no_line_breaks_in_" * 2


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_diagnosis_report(creeping(), path)
    return path


def exercised(page: Path, folder: Path, script: str) -> dict[str, str]:
    """What a script leaves in the data of the page's root when it has used the page."""
    elements, console = shown(with_script(page, script, folder / "used.html"), folder / "profile")
    assert console == []
    return elements.named("html")[0]


def test_it_reads_in_the_order_of_a_technician(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"<h[12][^>]*>(.*?)</h[12]>", text)
    assert headings == [
        "The rig creeps.",
        "How far it shrinks",
        "Where in the signal chain",
        "Which cause",
        "What cannot be told apart",
        "Where it lies",
        "Before and after",
        "The model&#x27;s own parameters",
        "The next experiment",
        "Warnings",
        "How to repeat it",
    ]
    model = page.parent / "model.yaml"
    assert f"microgripper simulate --model {model} &#x27;first run&#x27; --hold zero" in text
    assert "3 more that are unlikely; 1 not fitted to all samples: see its note" in text
    assert "contradicts" in text


@pytest.mark.parametrize(
    ("told", "claim"),
    [
        ({"free_form": 0.6}, "60 % of the removable error .* a free-form model closes it"),
        ({"free_form": 0.0, "by_driver": 0.5, "driver": "friction"}, "50 % .* friction is added"),
        ({"free_form": 0.0, "unseen": True}, ""),
    ],
)
def test_no_more_is_claimed_than_is_known_of_a_gap_that_nothing_explains(
    told: dict[str, object], claim: str, tmp_path: Path
) -> None:
    found = creeping()
    found = replace(found, verdict=UNKNOWN, effects=(), gap=replace(found.gap, **told))
    write_diagnosis_report(found, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8").replace("\N{NO-BREAK SPACE}", " ")
    said = [re.sub("<.*?>", "", p) for p in re.findall(r'<p class="claim">(.*?)</p>', text)]
    assert bool(said) == bool(claim)
    assert not said or re.search(claim, said[0])


def test_no_command_is_told_that_gives_a_part_of_a_recording(tmp_path: Path) -> None:
    found = creeping()
    part = replace(found.judged[0].recording, name="run.csv from 3.9 s", part=True)
    cut = replace(found, judged=(*found.judged, replace(found.judged[0], recording=part)))
    write_diagnosis_report(cut, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    commands = text[text.index("How to repeat it") :]
    assert "run.csv from 3.9 s" not in commands[: commands.index("</section>")]
    assert "cut at long gaps" in commands


def test_where_a_part_judged_the_page_says_what_a_command_prints(tmp_path: Path) -> None:
    found = creeping()
    strips = np.arange(4000) // 100 % 2 == 0
    judged = tuple(replace(one, counted=one.counted & strips) for one in found.judged)
    printed = [
        f"{1e9 * np.sqrt(np.mean((one.recording.measured - one.augmented)[one.counted] ** 2)):.1f}"
        for one in found.judged
    ]
    whole, part = tmp_path / "whole.html", tmp_path / "part.html"
    write_diagnosis_report(found, whole)
    write_diagnosis_report(replace(found, judged=judged), part)
    assert "as it was judged here" in whole.read_text(encoding="utf-8")
    told = part.read_text(encoding="utf-8")
    assert "as it was judged here" not in told
    assert f"over all of them it is {printed[0]} nm and {printed[1]} nm." in told


def test_of_a_model_that_rounds_no_command_repeats_what_was_judged(
    tmp_path: Path,
) -> None:
    found = creeping()
    grid = found.model.with_link("sensor_quantization", resolution=20e-9)
    write_diagnosis_report(replace(found, model=grid), tmp_path / "report.html")
    told = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "as it was judged here" not in told
    assert "It rounds as the sensor does, which the error told here leaves out." in told


def test_a_time_is_drawn_on_the_recording_that_it_is_of() -> None:
    found = creeping()
    later = Range("time_s", 2.0, 3.0, 0.5, recording="second run")
    found = replace(found, where=(later,))
    assert [len(gap_bands(found, "time_s", one.recording.name)) for one in found.judged] == [0, 1]


def test_a_rate_is_drawn_from_none_to_the_fastest_step() -> None:
    """The place is of a rate either way; the map's axis, of its sign, has no mark for it."""
    judged = creeping().judged[0]
    fastest = np.max(np.abs(np.diff(judged.recording.voltage))) / judged.recording.sample_period
    assert REACH["rate_V_per_s"](judged) == (0.0, pytest.approx(fastest))


def test_what_the_next_experiment_tells_reads_as_words(tmp_path: Path) -> None:
    found = creeping()
    assert found.next_experiment is not None
    for names, said in (
        (("creep",), "It tells whether creep is at work."),
        (("creep", "friction"), "It tells apart: creep and friction."),
    ):
        following = replace(found.next_experiment, separates=names)
        write_diagnosis_report(replace(found, next_experiment=following), tmp_path / "report.html")
        assert said in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_what_each_effect_accounts_for_is_told_of_several(tmp_path: Path) -> None:
    found = replace(creeping(), shares={"creep": 0.7, "friction": 0.3})
    write_diagnosis_report(found, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "How much each effect accounts for" in text


def test_figures_make_room_for_what_is_compared_and_no_more() -> None:
    found = creeping()
    recording = found.judged[0].recording
    displacement = recording.measured.copy()
    displacement[0] += 9e-6  # answers to what was before the recording
    judged = replace(found.judged[0], recording=replace(recording, displacement=displacement))
    drawn = recording_figures(found, judged)
    for name, most in (("residual", 2000.0), ("hysteresis", 3.0)):  # nm, µm
        figure = drawn[name]
        assert figure is not None
        for line in figure["series"]:  # type: ignore[attr-defined]
            low, high = line["height"]
            assert -most < low < high < most


def test_it_needs_nothing_but_itself(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    elements = Elements(text)
    for _, attributes in elements.all:
        assert not {"src", "onerror", "onload", "onclick"} & attributes.keys()
        assert attributes.get("href", "#").startswith("#")
    assert "@import" not in text
    assert "url(" not in text.replace("url(#${clip})", "")
    assert "default-src 'none'" in POLICY.search(text)[0].replace("&#x27;", "'")


def test_no_text_of_a_recording_becomes_markup(tmp_path: Path) -> None:
    found = creeping((HOSTILE,))
    candidates = [replace(c, note=HOSTILE) for c in found.candidates]
    hostile = replace(
        found,
        sentence=HOSTILE,
        candidates=tuple(candidates),
        warnings=(HOSTILE,),
        model=replace(found.model, name=HOSTILE),
    )
    write_diagnosis_report(hostile, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    elements = Elements(text)
    assert elements.named("img") == []
    assert len(elements.named("script")) == len(creeping_scripts(tmp_path))
    data = re.search(r'id="report-data">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    assert set(json.loads(data[1])) == {"recordings", "figures"}
    assert not set("<>&") & set(data[1])


def creeping_scripts(folder: Path) -> list[dict[str, str]]:
    write_diagnosis_report(creeping(("harmless",)), folder / "harmless.html")
    return Elements((folder / "harmless.html").read_text(encoding="utf-8")).named("script")


def test_long_recordings_make_a_small_page(tmp_path: Path) -> None:
    write_diagnosis_report(creeping(samples=44_000), tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size < LARGEST


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(MicrogripperError, match="file"):
        write_diagnosis_report(parameters_only(), tmp_path / "file" / "report.html")


@needs_browser
def test_every_figure_is_drawn_without_an_error(page: Path, tmp_path: Path) -> None:
    elements, console = shown(page, tmp_path)
    assert console == []
    assert elements.named("html")[0]["data-errors"] == "0"
    figures = {f["data-figure"]: f for f in elements.named("figure")}
    assert set(figures) == {name for name, *_ in FIGURES} | {"next"}
    assert all(figure.get("data-drawn") == "true" for figure in figures.values())
    for svg in elements.named("svg"):
        assert {"aria-label", "aria-hidden"} & svg.keys() or "chain" in svg["class"]


@needs_browser
def test_hostile_names_leave_no_trace_in_the_browser(tmp_path: Path) -> None:
    found = replace(creeping((HOSTILE,)), warnings=(HOSTILE,))
    write_diagnosis_report(found, tmp_path / "report.html")
    elements, console = shown(tmp_path / "report.html", tmp_path / "profile")
    assert console == []
    assert elements.named("img") == []
    assert "taken" not in elements.text.split("APA120S")[0]
    assert HOSTILE in elements.text


@needs_browser
@pytest.mark.parametrize("verdict", ["parameters", UNKNOWN])
def test_a_page_without_effects_and_rests(verdict: str, tmp_path: Path) -> None:
    found = replace(parameters_only(), verdict=verdict)
    write_diagnosis_report(found, tmp_path / "report.html")
    elements, console = shown(tmp_path / "report.html", tmp_path / "profile")
    assert console == []
    figures = {f["data-figure"]: f for f in elements.named("figure")}
    assert "hidden" in figures.pop("holds")
    assert all(figure.get("data-drawn") == "true" for figure in figures.values())


@needs_browser
def test_the_console_of_a_broken_page_is_seen(page: Path, tmp_path: Path) -> None:
    """So that its silence above means something."""
    text = page.read_text(encoding="utf-8").replace('"kind":"lines"', '"kind":"lines","bands":7')
    broken = tmp_path / "broken.html"
    broken.write_text(text, encoding="utf-8")
    assert shown(broken, tmp_path / "profile")[1] != []


@needs_browser
def test_figures_zoom_together_and_lines_are_read_and_hidden(page: Path, tmp_path: Path) -> None:
    found = exercised(
        page,
        tmp_path,
        """
        const tell = (name, value) => { document.documentElement.dataset[name] = value; };
        const all = (figure, what) =>
          [...document.querySelectorAll(`figure[data-figure=${figure}] ${what}`)];
        const ticks = () => all("response", "text.tick").map((tick) => tick.textContent).join(" ");
        const press = (key) => all("residual", "svg[role=img]")[0]
          .dispatchEvent(new KeyboardEvent("keydown", { key }));
        const loop = () => all("loops", ".plot path")[0].getAttribute("d").length;
        tell("whole", ticks()); tell("loop", loop());
        press("+"); press("+");
        tell("zoomed", ticks()); tell("part", loop());
        press("ArrowRight");
        tell("read", all("residual", ".value").map((value) => value.textContent).join());
        press("Escape");
        tell("again", ticks());
        tell("lines", all("residual", ".plot path").length);
        all("residual", ".legend button")[0].click();
        tell("more", all("residual", ".plot path").length);
        """,
    )
    assert found["data-whole"].startswith("0 1 2 3 4")
    assert found["data-zoomed"].startswith("1.6 1.8 2 2.2 2.4 ")
    assert int(found["data-part"]) < 0.7 * int(found["data-loop"])
    assert re.fullmatch(f",[{MINUS}.0-9]+ nm,[{MINUS}.0-9]+ nm", found["data-read"])
    assert found["data-again"] == found["data-whole"]
    assert (found["data-lines"], found["data-more"]) == ("2", "3")


@needs_browser
def test_another_recording_is_drawn_when_it_is_chosen(page: Path, tmp_path: Path) -> None:
    found = exercised(
        page,
        tmp_path,
        """
        const line = () => document
          .querySelector("figure[data-figure=voltage] .plot path").getAttribute("d");
        const [first, chooser] = [line(), document.getElementById("recording")];
        chooser.value = "1";
        chooser.dispatchEvent(new Event("change"));
        document.documentElement.dataset.changed = line() !== first;
        """,
    )
    assert found["data-changed"] == "true"


@needs_browser
def test_it_prints(page: Path, tmp_path: Path) -> None:
    run(page, tmp_path / "profile", f"--print-to-pdf={tmp_path / 'report.pdf'}")
    pdf = (tmp_path / "report.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 16


@needs_browser
@pytest.mark.parametrize("width", [360, 500])
def test_nothing_is_wider_than_a_phone(page: Path, width: int, tmp_path: Path) -> None:
    assert framed(page, tmp_path, width) == ([], len(FIGURES) + 1)


@needs_browser
@pytest.mark.parametrize("width", [360, 500, 1000])
def test_long_names_do_not_make_it_wider(width: int, tmp_path: Path) -> None:
    found = creeping((f"{LONG}_run", f"{LONG}_again"))
    named = replace(
        found,
        sentence=f"{LONG} creeps. Adding creep helps.",
        warnings=(f"{LONG}: 3 samples were missing",),
        nominal=replace(found.nominal, name=LONG, description=LONG),
        model=replace(found.model, name=LONG, description=LONG),
        candidates=tuple(replace(one, note=LONG) for one in found.candidates),
    )
    write_diagnosis_report(named, tmp_path / "report.html")
    assert framed(tmp_path / "report.html", tmp_path, width).too_wide == []
