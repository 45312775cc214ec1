"""All ways of simulating and fitting that the benchmark compares do the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.bench import rig
from microgripper_control.bench.rivals import in_c
from microgripper_control.bench.rivals.scripted import Script, numpy_loop
from microgripper_control.bench.rivals.scripted_fit import (
    KEYS,
    compiled_model,
    evolution_script,
    least_squares_script,
)
from microgripper_control.bench.rows import simulation
from microgripper_control.bench.rows.diagnosis import PLANTED, textbook
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.identification.fit import fit
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

ROUNDING = 1e-16  # m

VOLTAGE = rig.voltage(2000)


@pytest.fixture
def script() -> Script:
    return Script(rig.nominal_values(), VOLTAGE[:40], rig.SAMPLE_PERIOD)


def test_c_gives_the_same_to_rounding(tmp_path: Path) -> None:
    cc = in_c.compiler()
    if cc is None:
        pytest.skip("no C compiler")
    chain = in_c.ChainInC(tmp_path, cc, simulation.bouc_wen_numbers(), rig.mechanics_step())
    ours = simulate(nominal_model(), VOLTAGE, rig.SAMPLE_PERIOD)
    displacement = np.full_like(VOLTAGE, np.nan)
    chain.simulate(VOLTAGE, displacement)
    np.testing.assert_allclose(displacement, ours, rtol=0.0, atol=ROUNDING)


def test_without_a_compiler_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert in_c.compiler() is None


def test_the_numpy_loop_gives_the_same_to_rounding() -> None:
    ours = simulate(nominal_model(), VOLTAGE, rig.SAMPLE_PERIOD)
    loop = numpy_loop(rig.nominal_values(), rig.mechanics_step(), VOLTAGE)
    np.testing.assert_allclose(loop, ours, rtol=0.0, atol=10.0 * ROUNDING)


@pytest.mark.parametrize("method", ["RK45", "BDF", "LSODA"])
def test_solve_ivp_comes_to_the_same(script: Script, method: str) -> None:
    off = np.max(np.abs(script.solve_ivp(method, 1e-8, 1e-8) - simulation.exact(script)))
    assert off < 1e-11


def test_odeint_comes_to_the_same(script: Script) -> None:
    assert np.max(np.abs(script.odeint(1e-9, 1e-9) - simulation.exact(script))) < 1e-12


@pytest.mark.parametrize("choose", [simulation.choose_solve_ivp, simulation.choose_odeint])
def test_the_integrators_that_are_timed_are_accurate_enough(
    script: Script,
    choose: Callable[[Script], simulation.Chosen],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(simulation, "METHODS", ("LSODA", "BDF"))
    monkeypatch.setattr(simulation, "RTOLS", (1e-3, 1e-6))
    chosen = choose(script)
    off = np.sqrt(np.mean((chosen.solve() - simulation.exact(script)) ** 2))
    assert off == chosen.error <= simulation.ACCURACY


def test_an_integrator_is_not_made_slow_by_an_unlucky_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Settings that need a hundred times more are accurate, too."""
    script = Script(rig.nominal_values(), rig.voltage(simulation.SHORT), rig.SAMPLE_PERIOD)
    chosen, asked = simulation.choose_odeint(script), 0
    rates = script.rates()

    def counted(time: float, state: Sequence[float]) -> tuple[float, float, float]:
        nonlocal asked
        asked += 1
        return rates(time, state)

    monkeypatch.setattr(Script, "rates", lambda self: counted)
    chosen.solve()
    assert asked < 10 * simulation.SHORT


def test_a_method_that_is_slow_at_its_loosest_is_passed_over(
    script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    def solve_ivp(self: Script, method: str, rtol: float, atol: float) -> Array:
        tried.append(method)
        return simulation.exact(self)

    monkeypatch.setattr(Script, "solve_ivp", solve_ivp)
    pace = {"RK45": 1.0, "LSODA": 0.1}
    monkeypatch.setattr(simulation, "METHODS", ("RK45", "LSODA"))
    monkeypatch.setattr(simulation, "_seconds", lambda solve, of: pace[solve.keywords["method"]])
    assert simulation.choose_solve_ivp(script).about.startswith("solve_ivp, LSODA")
    assert set(tried) == {"LSODA"}


def test_the_fastest_that_is_accurate_enough_is_taken(
    script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Be its tolerances tight or loose: time goes by as the settings say."""
    spent = {(1e-3, 1e-2): 1.0, (1e-12, 2e-4): 2.0, (1e-12, 1e-6): 3.0}

    def odeint(self: Script, rtol: float, atol: float) -> Array:
        off = 2e-9 if atol == 1e-2 else 5e-10
        return simulation.exact(self) + off

    monkeypatch.setattr(Script, "odeint", odeint)
    monkeypatch.setattr(
        simulation,
        "_seconds",
        lambda solve, of: spent.get((solve.keywords["rtol"], solve.keywords["atol"]), 9.0),
    )
    assert simulation.choose_odeint(script).about == "odeint, rtol 1e-12, atol 0.0002 um"


def test_an_integrator_that_is_never_accurate_enough_is_told(
    script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulation, "ACCURACY", 0.0)
    monkeypatch.setattr(simulation, "RTOLS", (1e-3, 1e-6))
    with pytest.raises(MicrogripperError, match="odeint is within 0 m rms at none of"):
        simulation.choose_odeint(script)


def test_all_fits_find_the_same() -> None:
    model = nominal_model()
    recording, start = rig.recording(model, samples=4000), rig.mistuned(model)
    ours = fit(start, [recording], Conditions(initial=Initial.REST)).model
    simulator = compiled_model(recording)
    for script in (least_squares_script, evolution_script):
        found = script(start, recording, simulator)
        assert found.simulations > len(KEYS)
        for key in KEYS:
            interval = ours.settings[key[0]][key[1]].interval
            assert interval is not None
            width = interval[1] - interval[0]
            assert abs(found.model.value(*key) - ours.value(*key)) < 0.5 * width


def test_the_textbook_names_what_was_planted() -> None:
    planted = nominal_model().with_link(PLANTED)
    assert textbook(nominal_model(), [rig.recording(planted, samples=6000)]) == PLANTED
