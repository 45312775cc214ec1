"""What each row makes of the times that it takes: ratios are the right way round.

The clock is told what everything takes; nothing is measured here.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from microgripper_control.bench import rig
from microgripper_control.bench.rivals import in_c
from microgripper_control.bench.rivals.scripted_fit import Scripted
from microgripper_control.bench.row import Effort, Line
from microgripper_control.bench.rows import (
    diagnosis,
    growth,
    identification,
    lockstep,
    reading,
    simulation,
    startup,
    streaming,
)
from microgripper_control.bench.timing import Contestant, Times
from microgripper_control.plant.model import nominal_model

Take = Callable[[ModuleType, Mapping[str, float]], None]
Spend = Callable[[ModuleType, str, float, object], None]


@pytest.fixture
def take(monkeypatch: pytest.MonkeyPatch) -> Take:
    """Makes the contestants of a row take so many seconds per unit of work."""

    def take(row: ModuleType, seconds: Mapping[str, float]) -> None:
        def take_turns(contestants: Mapping[str, Contestant], rounds: int) -> Times:
            return Times({name: np.full(3, seconds[name]) for name in contestants})

        monkeypatch.setattr(row, "take_turns", take_turns)

    return take


@pytest.fixture
def spend(monkeypatch: pytest.MonkeyPatch) -> Spend:
    """Has a function of a row take so many seconds, by its clock, and return something."""
    now = 0.0
    monkeypatch.setattr("time.perf_counter", lambda: now)

    def spend(row: ModuleType, name: str, seconds: float, found: object) -> None:
        def call(*given: object, **more: object) -> object:
            nonlocal now
            now += seconds
            return found

        monkeypatch.setattr(row, name, call)

    return spend


def against(lines: tuple[Line, ...], rival: str) -> Line:
    return next(line for line in lines if rival in line.against)


def test_simulation_is_so_many_times_as_fast(
    take: Take, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    held, straight = 1e-8, 2e-8
    seconds = {"solve_ivp": 2e-6, "odeint": 1e-6, "numpy": 5e-6, "C": 9e-9, "C, native": 8e-9}
    take(simulation, {"ours, held": held, "ours, straight": straight, **seconds})
    for integrator in ("solve_ivp", "odeint"):
        chosen = simulation.Chosen(integrator, lambda: np.zeros(1), 1e-10)
        monkeypatch.setattr(simulation, f"choose_{integrator}", lambda script, it=chosen: it)
    monkeypatch.setattr(in_c, "compiler", lambda: "cc")
    monkeypatch.setattr(in_c, "ChainInC", lambda *given: SimpleNamespace(simulate=print))
    lines = simulation.measure(Effort(tmp_path)).lines
    figures = [line.figure.median for line in lines]
    assert figures == pytest.approx([2e-6 / straight, 1e-6 / straight, 5e-6 / held, 0.9, 0.8])
    assert [line.outcome for line in lines] == ["met", "met", "", "met", ""]


def test_a_streaming_step_takes_so_many_times_as_long(take: Take, tmp_path: Path) -> None:
    take(streaming, defaultdict(lambda: 2e-6, call=4e-8))
    lines = streaming.measure(Effort(tmp_path)).lines
    assert [line.figure.median for line in lines] == pytest.approx(3 * [2e-6, 50.0])


def test_identification_is_so_many_times_as_fast(
    take: Take, spend: Spend, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    seconds = {"ours": 0.5, "unknown": 0.6, "quick script": 0.1, "solve_ivp": 1e-4}
    take(identification, seconds)
    spend(identification, "evolution_script", 2.0, Scripted(nominal_model(), 2000))
    spend(identification, "least_squares_script", 0.0, Scripted(nominal_model(), 30))
    spend(identification, "fit", 0.0, SimpleNamespace(determined=("d", "alpha")))
    chosen = simulation.Chosen("solve_ivp", lambda: np.zeros(1), 1e-10)
    monkeypatch.setattr(identification, "choose_solve_ivp", lambda script: chosen)
    lines = identification.measure(Effort(tmp_path)).lines
    assert [line.figure.median for line in lines[:2]] == [0.5, 0.6]
    scripted = 1e-4 * 30 * rig.SAMPLES
    assert against(lines, "solve_ivp").figure.median == pytest.approx(scripted / 0.5)
    assert against(lines, "evolution").figure.median == pytest.approx(2.0 / 0.5)
    assert against(lines, "least squares").figure.median == pytest.approx(0.1 / 0.5)


def test_reading_is_so_many_times_as_fast(
    take: Take, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    take(reading, {"ours": 1e-7, "theirs": 2e-6})
    monkeypatch.setattr(reading, "write_bag", lambda *given: None)
    lines = reading.measure(Effort(tmp_path)).lines
    assert [line.figure.median for line in lines] == pytest.approx([20.0, 20.0])


def test_a_diagnosis_takes_so_many_times_as_long(spend: Spend, tmp_path: Path) -> None:
    spend(diagnosis, "diagnose", 22.0, SimpleNamespace(effects=("creep",), verdict=""))
    spend(diagnosis, "textbook", 88.0, "creep")
    lines = diagnosis.measure(Effort(tmp_path)).lines
    recorded = 2.0 * rig.SAMPLES * rig.SAMPLE_PERIOD
    assert against(lines, "recorded").figure.median == pytest.approx(22.0 / recorded, rel=1e-3)
    assert against(lines, "textbook").figure.median == pytest.approx(22.0 / 88.0)


def test_growth_and_memory_are_by_sample(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(growth, "SAMPLES", (1000, 10_000, 100_000))
    calls = {size: Contestant(lambda: None) for size in (2, 4, 8)}
    for name in ("_diagnoses", "_fits"):
        monkeypatch.setattr(growth, name, lambda: calls)
    monkeypatch.setattr(growth, "write_long_bag", lambda bag, size: None)
    monkeypatch.setattr(growth, "simulate", lambda model, u, period: bytearray(50 * len(u)))
    monkeypatch.setattr(growth, "read_recording", lambda bag: bytearray(70 * int(bag.stem)))

    def take_turns(contestants: Mapping[str, Contestant], rounds: int) -> Times:
        return Times({size: np.full(3, float(size) ** 2) for size in contestants})

    monkeypatch.setattr(growth, "take_turns", take_turns)
    lines = growth.measure(Effort(tmp_path)).lines
    assert [line.figure.median for line in lines[:4]] == pytest.approx([2.0] * 4)
    assert [line.figure.median for line in lines[4:]] == pytest.approx([50.0, 70.0], rel=0.05)
    assert [line.outcome for line in lines] == ["missed"] * 4 + ["met"] * 2


def test_a_node_takes_so_much_longer_to_start(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(startup, "check_ros", lambda: None)
    monkeypatch.setattr(
        startup, "until_ready", lambda words, env, effort: 0.25 if words[0] == "-c" else 1.0
    )
    lines = startup.measure(Effort(tmp_path)).lines
    assert len(lines) == len(startup.NODES)
    assert [line.figure.median for line in lines] == pytest.approx([0.75] * len(lines))


class SaidNodes:
    """Nodes that have run 3000 samples, by how many there are: 2 in 1 s, 4 in 2 s."""

    def __init__(self, log_folder: Path) -> None:
        self._log, self._started = log_folder, 0

    def __enter__(self) -> SaidNodes:
        self._log.mkdir(exist_ok=True)
        return self

    def __exit__(self, *given: object) -> None:
        pass

    def start(self, name: str, **parameters: object) -> SimpleNamespace:
        self._started += 1
        log = self._log / name
        log.write_text(f"[INFO] 3000 samples in {self._started / 2:.1f} s\n", encoding="utf-8")
        return SimpleNamespace(log=log)

    def wait_for(self, node: SimpleNamespace, timeout: float) -> None:
        pass


def test_lockstep_is_so_many_times_as_fast_as_real_time(
    take: Take, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(lockstep, "check_ros", lambda: None)
    monkeypatch.setattr(lockstep, "Nodes", SaidNodes)
    take(lockstep, {"run": 4e-6})
    lines = lockstep.measure(Effort(tmp_path)).lines
    assert [line.figure.median for line in lines] == pytest.approx([3.0, 1.5, 250.0])
