"""Whole diagnoses of planted rigs: the base parameters are off, the sensor is noisy."""

from __future__ import annotations

import html
import json
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from typer.testing import CliRunner

from microgripper_control.cli.main import app
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.diagnose import candidate_names, diagnose
from microgripper_control.diagnosis.findings import EFFECTS, NONE, PARAMETERS, UNKNOWN
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search import from_guesses
from microgripper_control.diagnosis.search.labour import is_force
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model, save_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.csv import write_csv

PERIOD, NOISE = 1e-3, 15e-9
FORCES = [name for name in candidate_names() if is_force(name)]  # costly: two minutes of a pair's
MISTUNED = {"d": 1.07, "alpha": 0.92, "beta": 1.1, "gamma": 0.93}


def course(seconds: float, seed: int) -> Array:
    """Slow loops, steps with holds and a multisine, V, a third each."""
    rng = np.random.default_rng(seed)
    third = round(seconds / PERIOD / 3)
    t = PERIOD * np.arange(third)
    loops = 70.0 * (1.0 - np.cos(2.0 * np.pi * 0.8 * t)) * np.linspace(1.0, 0.4, third)
    steps = np.repeat(rng.uniform(10.0, 140.0, 5), -(-third // 5))[:third]
    phases = rng.uniform(0.0, 2.0 * np.pi, 5)
    rates = (0.9, 2.3, 6.1, 14.0, 29.0)
    sines = sum(np.sin(2.0 * np.pi * f * t + p) for f, p in zip(rates, phases, strict=True))
    return np.concatenate([loops, steps, 75.0 + 20.0 * np.asarray(sines)])


def record(rig: Model, seconds: float, seed: int) -> Recording:
    voltage = course(seconds, seed)
    noise = NOISE * np.random.default_rng(1000 + seed).standard_normal(len(voltage))
    return Recording(f"run {seed}", PERIOD, voltage, simulate(rig, voltage, PERIOD) + noise)


@pytest.fixture(scope="module")
def paper() -> Model:
    return load_model(Path(__file__).parents[2] / "config" / "apa120s.yaml")


@pytest.fixture
def mistuned(paper: Model) -> Callable[[Model], Model]:
    def off(model: Model) -> Model:
        return model.with_values(
            {("bouc_wen", n): f * model.value("bouc_wen", n) for n, f in MISTUNED.items()}
        )

    return off


def test_a_right_model_needs_nothing(paper: Model) -> None:
    found = diagnose(paper, [record(paper, 9.0, 1)], [record(paper, 9.0, 2)])
    assert (found.verdict, found.effects) == (NONE, ())
    assert found.model == paper
    assert found.gap.nominal == pytest.approx(NOISE, rel=0.03)
    assert found.gap.noise_floor == pytest.approx(NOISE, rel=0.03)


def clipped(recording: Recording) -> Recording:
    return replace(recording, displacement=np.minimum(recording.measured, 16e-6))


def test_what_a_clipped_sensor_makes_of_a_right_model_is_no_contact(paper: Model) -> None:
    found = diagnose(paper, [clipped(record(paper, 9.0, 1))], [clipped(record(paper, 9.0, 2))])
    assert (found.verdict, found.effects) == (UNKNOWN, ())
    assert sum(line.endswith("they look clipped") for line in found.warnings) == 2


def test_a_stop_that_clips_without_noise_is_still_looked_for(paper: Model) -> None:
    voltage = course(9.0, 1)
    rig = paper.with_link("saturation", high=100.0)
    said = Recording("run", PERIOD, voltage, simulate(rig, voltage, PERIOD))
    assert diagnose(paper, [said]).effects == ("saturation",)


def test_a_mistuned_model_is_fitted_again(paper: Model, mistuned: Callable[[Model], Model]) -> None:
    found = diagnose(mistuned(paper), [record(paper, 9.0, 1)], [record(paper, 9.0, 2)])
    assert (found.verdict, found.effects) == (PARAMETERS, ())
    assert found.gap.augmented == pytest.approx(NOISE, rel=0.03)
    assert found.gap.nominal > 10.0 * NOISE


@pytest.mark.parametrize(("pole", "verdict"), [(0.7, PARAMETERS), (0.995, UNKNOWN)])
def test_noise_that_a_filter_has_coloured_is_no_cause(
    paper: Model, mistuned: Callable[[Model], Model], pole: float, verdict: str
) -> None:
    """It is forgotten after some samples; what lasts longer is a disturbance."""
    rng = np.random.default_rng(11)

    def noisy(seed: int) -> Recording:
        recording = record(paper, 9.0, seed)
        added = 4.0 * NOISE * lfilter([1.0], [1.0, -pole], rng.standard_normal(len(recording)))
        return replace(recording, displacement=recording.measured + added)

    others = set(candidate_names()) - {"creep", "amplifier_lag"}
    found = diagnose(mistuned(paper), [noisy(1)], [noisy(2)], without=others)
    assert found.verdict == verdict


def test_the_makers_rig_with_its_coarse_sensor_is_only_fitted_again(
    mistuned: Callable[[Model], Model],
) -> None:
    """Readings on steps of 1 um, 2.45 instead of 2.67 ms old, of a mass that rings: none is new."""
    maker = load_model(Path(__file__).parents[2] / "config" / "apa120s_datasheet.yaml")
    late = {("transport_delay", "delay"): 2.45e-3, ("second_order", "m"): 5.3e-3}
    rig = mistuned(maker.with_values(late))
    long = ("contact", "friction", "restoring_force_hysteresis")
    found = diagnose(maker, [record(rig, 9.0, 1)], [record(rig, 9.0, 2)], without=long)
    assert (found.verdict, found.effects) == (PARAMETERS, ())
    assert found.model.effects == maker.effects
    assert found.model.value("sensor_quantization", "resolution") == 1e-6
    assert found.gap.augmented < 0.3e-6 < found.gap.nominal
    assert found.gap.noise_floor <= found.gap.augmented


@pytest.mark.parametrize("separate", [True, False])
def test_what_is_too_long_to_be_simulated_is_diagnosed_in_pieces(
    paper: Model,
    mistuned: Callable[[Model], Model],
    monkeypatch: pytest.MonkeyPatch,
    *,
    separate: bool,
) -> None:
    """All of it is shown, beside what the models say, and no warning compares whole and part."""
    monkeypatch.setattr("microgripper_control.diagnosis.data.evidence.MOST_SIMULATED", 10_000)
    monkeypatch.setattr("microgripper_control.diagnosis.data.evidence.MOST_COMPARED", 5_000)
    runs = [record(paper, 24.0, 1), record(paper, 24.0, 2)]
    given, kept = (runs[:1], runs[1:]) if separate else (runs, [])
    nominal = replace(mistuned(paper), voltage_range=(-30.0, 170.0))  # all that is driven
    found = diagnose(nominal, given, kept, without={*candidate_names()} - {"creep"})
    assert (found.verdict, found.effects, found.warnings) == (PARAMETERS, (), ())
    assert [len(one.position) for one in found.judged] == [24_000] * len(kept or runs)
    assert found.gap.refit == pytest.approx(NOISE, rel=0.1)


@pytest.fixture(scope="module")
def planted() -> dict[str, dict[str, float]]:
    return {
        "creep": {"strength": 0.01},
        "transport_delay": {"delay": 0.0024},
        "contact": {"position": 1.2e-5, "stiffness": 2e6},
        "backlash": {"play": 3e-7},
    }


@pytest.mark.parametrize("name", ["creep", "transport_delay", "contact", "backlash"])
def test_a_planted_effect_is_named(
    paper: Model,
    mistuned: Callable[[Model], Model],
    planted: dict[str, dict[str, float]],
    name: str,
) -> None:
    """Without recordings of their own to judge, blocks are held out."""
    rig = paper.with_link(name, **planted[name])
    found = diagnose(mistuned(paper), [record(rig, 15.0, 3)])
    assert (found.verdict, found.effects) == (EFFECTS, (name,))
    assert found.candidates[0].effect == name
    assert found.candidates[0].probability > 0.5
    assert found.gap.augmented < 1.1 * NOISE
    assert found.gap.closed > 0.9
    assert found.gap.closed_low <= found.gap.closed <= found.gap.closed_high
    assert sum(candidate.probability for candidate in found.candidates) == pytest.approx(1.0)
    tried = {candidate.effect for candidate in found.candidates}
    assert tried == {*candidate_names(), "none", "parameters", "unknown"}


def test_a_memory_about_as_stiff_as_the_rig_is_found(
    paper: Model, mistuned: Callable[[Model], Model]
) -> None:
    """Of which a refit of the material takes all but three times the noise."""
    name = "restoring_force_hysteresis"
    rig = paper.with_link(name, alpha=4e7, beta=2.3e5, gamma=1e5)

    def ramps(turns: Sequence[float], seed: int) -> Recording:
        places = np.linspace(0.0, 2999.0, len(turns))
        voltage = np.interp(np.arange(3000.0), places, turns)
        noise = NOISE * np.random.default_rng(seed).standard_normal(3000)
        moved = simulate(rig, voltage, 2.0 * PERIOD, hold=Hold.FIRST)
        return Recording(f"ramps {seed}", 2.0 * PERIOD, voltage, moved + noise)

    inwards = ramps([0, 150, 0, 120, 20, 100, 35, 85, 50, 75, 60], 1)
    outwards = ramps([0, 60, 30, 110, 70, 150, 100, 130, 0, 50, 20], 2)
    others = ramps([0, 90, 10, 140, 60, 100, 80, 120, 30, 70, 0], 3)
    found = diagnose(
        mistuned(paper),
        [inwards, outwards],
        [others],
        Conditions(hold=Hold.FIRST),
        without=set(candidate_names()) - {name},
    )
    assert found.effects == (name,)
    assert found.gap.refit > 3.0 * NOISE
    assert found.gap.augmented < 1.1 * NOISE


def test_two_effects_are_both_named(paper: Model, mistuned: Callable[[Model], Model]) -> None:
    rig = paper.with_link("creep", strength=0.015).with_link("backlash", play=3e-7)
    runs = [record(rig, 15.0, 4)], [record(rig, 15.0, 5)]
    found = diagnose(mistuned(paper), *runs, without=FORCES)
    assert found.verdict == EFFECTS
    assert set(found.effects) == {"creep", "backlash"}
    assert set(found.shares) == {"creep", "backlash"}
    assert sum(found.shares.values()) == pytest.approx(1.0)


def test_what_only_the_held_out_recordings_reach_is_named(
    paper: Model, mistuned: Callable[[Model], Model]
) -> None:
    """Loops too slow for the amplifier's limit are fitted, fast ones judge."""
    rig = paper.with_link("slew_limit", time=1.0 / 1000.0)
    time = PERIOD * np.arange(12_000)

    def loops(frequency: float, seed: int) -> Recording:
        sweep = 1.0 + 0.2 * np.sin(0.9 * time)
        voltage = 70.0 - 60.0 * np.cos(2.0 * np.pi * frequency * time) * sweep / 1.2
        noise = NOISE * np.random.default_rng(seed).standard_normal(len(time))
        return Recording(f"{seed}", PERIOD, voltage, simulate(rig, voltage, PERIOD) + noise)

    found = diagnose(mistuned(paper), [loops(0.7, 1), loops(1.1, 2)], [loops(4.1, 3)])
    assert (found.verdict, found.effects) == (EFFECTS, ("slew_limit",))
    assert any("only the held-out recordings show the gap" in line for line in found.warnings)
    assert found.gap.unseen
    assert found.gap.driver
    assert found.gap.by_driver == max(c.share for c in found.candidates)
    assert not found.gap.separate
    assert found.gap.augmented < 1.2 * NOISE


def test_what_the_fitted_recordings_show_clearly_is_fitted_to_them_alone(
    paper: Model, mistuned: Callable[[Model], Model]
) -> None:
    """A mode rings a little after steps; in a chirp far more, but in a block that judges."""
    rig = paper.with_link("extra_resonance", share=0.04, frequency=25.0, damping=0.02)
    time = PERIOD * np.arange(12_000)
    levels = np.append(0.0, np.random.default_rng(5).uniform(10.0, 140.0, 11))
    steps = np.repeat(levels, 1000)
    chirp = 75.0 - 65.0 * np.cos(np.pi * 55.0 / time[-1] * time**2)
    noise = NOISE * np.random.default_rng(1).standard_normal((2, len(time)))
    recordings = [
        Recording(name, PERIOD, voltage, simulate(rig, voltage, PERIOD) + errors)
        for name, voltage, errors in (("steps", steps, noise[0]), ("chirp", chirp, noise[1]))
    ]
    found = diagnose(mistuned(paper), recordings[:1], recordings[1:])
    assert (found.verdict, found.effects) == (EFFECTS, ("extra_resonance",))
    assert found.gap.separate
    assert found.gap.augmented < 1.2 * NOISE


def test_a_drift_is_not_called_creep_from_before_the_recordings(paper: Model) -> None:
    """Without drift in the library, what creep leaves to each recording could do all of it."""

    def drifting(seed: int) -> Recording:
        run = record(paper, 15.0, seed)
        time = PERIOD * np.arange(len(run))
        drift = 4e-7 * np.random.default_rng(seed).choice([-1.0, 1.0]) * np.exp(-time / 4.0)
        return Recording(run.name, PERIOD, run.voltage, run.measured + drift)

    without = ["thermal_drift", *FORCES]
    found = diagnose(paper, [drifting(1), drifting(2)], [drifting(4)], without=without)
    assert "creep" not in found.effects
    (creep,) = (candidate for candidate in found.candidates if candidate.effect == "creep")
    assert "from before the recordings" in creep.note


def test_what_was_commanded_before_a_recording_began_is_blamed_on_nothing(paper: Model) -> None:
    """Cut out of a run just after a step that the rig has not answered yet."""
    period = 5e-3
    time = period * np.arange(1200)
    steps = 35.0 * np.sin(7.1 * np.floor(time / 0.3))
    voltage = 80.0 + steps + 30.0 * np.sin(2.6 * np.pi * time)
    noise = NOISE * np.random.default_rng(5).standard_normal(len(voltage))
    rig = paper.with_link("transport_delay", delay=2.0 * period)
    cut = slice(241, None)
    assert voltage[239] - voltage[240] > 25.0
    run = Recording("run", period, voltage[cut], (simulate(rig, voltage, period) + noise)[cut])
    assert diagnose(paper, [run]).effects == ("transport_delay",)


def test_a_candidate_that_fails_stops_no_other_and_is_listed(
    paper: Model, mistuned: Callable[[Model], Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = from_guesses.guesses

    def fails(*given: object, **options: object) -> object:
        if "backlash" in given:
            raise FloatingPointError("overflow in the play")
        return real(*given, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(from_guesses, "guesses", fails)
    rig = paper.with_link("transport_delay", delay=0.0024)
    found = diagnose(mistuned(paper), [record(rig, 9.0, 6)], jobs=1)
    assert found.effects == ("transport_delay",)
    notes = {candidate.effect: candidate.note for candidate in found.candidates}
    assert "overflow in the play" in notes["backlash"]


def test_a_last_fit_that_diverges_where_it_is_judged_is_not_reported(
    paper: Model, mistuned: Callable[[Model], Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spring that gives way held until a loop of the held-out recordings was larger."""

    def diverges(_: Evidence, trial: Trial, *limits: float) -> Trial:
        return replace(trial, errors=tuple(np.full_like(error, np.nan) for error in trial.errors))

    monkeypatch.setattr("microgripper_control.diagnosis.diagnose.refined", diverges)
    rig = paper.with_link("transport_delay", delay=0.0024)
    others = set(candidate_names()) - {"transport_delay"}
    found = diagnose(mistuned(paper), [record(rig, 9.0, 6)], jobs=1, without=others)
    assert found.effects == ("transport_delay",)
    assert found.gap.augmented < 1.1 * NOISE


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory, paper: Model) -> Path:
    """A model that is off and two recordings of a late rig."""
    folder = tmp_path_factory.mktemp("late")
    rig = paper.with_link("transport_delay", delay=0.0024)
    for seed, name in ((7, "run.csv"), (8, "held.csv")):
        write_csv(folder / name, record(rig, 9.0, seed))
    off = {("bouc_wen", n): f * paper.value("bouc_wen", n) for n, f in MISTUNED.items()}
    save_model(paper.with_values(off), folder / "model.yaml")
    return folder


def run(*arguments: object) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_simulate_repeats_the_held_out_error_to_the_last_digit(files: Path) -> None:
    out = files / "out"
    common = ("--model", files / "model.yaml", files / "run.csv", "--heldout", files / "held.csv")
    printed = run("diagnose", *common, "--out", out)
    assert "late" in printed
    found = json.loads((out / "diagnosis.json").read_text())
    assert found["schema"] == "microgripper-diagnosis/1"
    assert found["effects"] == ["transport_delay"]
    again = json.loads(
        run(
            "simulate",
            "--model",
            out / "model.yaml",
            files / "held.csv",
            "--out",
            out / "predicted.csv",
            "--json",
        )
    )
    assert again["rmse_m"] == found["gap"]["augmented_rmse_m"]
    assert (out / "report.html").stat().st_size > 1e5


def test_the_report_says_how_to_repeat_it_with_other_peoples_columns(files: Path) -> None:
    out, theirs = files / "mapped", ["voltage=u", "displacement=x*1e-6"]
    header, *rows = (files / "run.csv").read_text().splitlines()
    order = header.split(",")
    assert order == ["time_s", "voltage_V", "displacement_m"]
    micro = [(t, u, float(x) * 1e6) for t, u, x in (row.split(",") for row in rows)]
    (files / "theirs.csv").write_text(
        "time_s,u,x\n" + "".join(f"{t},{u},{x!r}\n" for t, u, x in micro)
    )
    maps = [word for one in theirs for word in ("--map", one)]
    run("diagnose", "--model", files / "model.yaml", files / "theirs.csv", *maps, "--out", out)
    page = html.unescape((out / "report.html").read_text())
    (command,) = re.findall(r"microgripper (simulate --model .*) --out predicted.csv", page)
    again = run(*shlex.split(command), "--out", out / "predicted.csv", "--json")
    found = json.loads((out / "diagnosis.json").read_text())
    assert json.loads(again)["rmse_m"] == found["gap"]["augmented_rmse_m"]


def test_what_is_found_does_not_depend_on_how_many_work(files: Path) -> None:
    common = ("--model", files / "model.yaml", files / "run.csv")
    alone, together = (
        run("diagnose", *common, "--out", files / f"jobs{jobs}", "--jobs", jobs, "--json")
        for jobs in (1, 2)
    )
    assert alone.replace("jobs1", "") == together.replace("jobs2", "")
