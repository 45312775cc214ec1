"""The chain with all effects on is judged by what each of them adds alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.bench.row import MET, Effort
from microgripper_control.bench.rows import effects
from microgripper_control.bench.timing import Contestant, Times
from microgripper_control.effects.registry import registry

NOMINAL, ADDED = 5e-9, {True: 70e-9, False: 20e-9}  # s a step, by whether it is a force


def linear(contestants: Mapping[str, Contestant], rounds: int) -> Times:
    """What a chain would take that is linear in its links and their steps."""
    links = [link for link in registry().values() if not (link.nominal or link.sampled)]
    alone = {link.name: ADDED[bool(link.force)] for link in links}
    forces = sum(ADDED[True] for link in links if link.force)
    others = sum(ADDED[False] for link in links if not link.force)
    whole = effects.Subject.having(list(alone))
    both = forces + others * whole.chain.steps / whole.steps
    added = {**alone, "forces": forces, "others": others, "all": both}
    return Times({name: np.full(3, NOMINAL + added.get(name, 0.0)) for name in contestants})


def test_effects_that_add_up_are_linear(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(effects, "take_turns", linear)
    sums = effects.measure(Effort(tmp_path)).lines[:3]
    assert [line.what.split()[2] for line in sums] == ["10", "4", "all"]
    for line in sums:
        assert line.figure == pytest.approx((1.0, 1.0, 1.0))
        assert line.outcome == MET


@pytest.mark.parametrize("force", ["friction", "contact"])
def test_substeps_are_counted_for_the_course_that_reaches_the_mechanics(force: str) -> None:
    jumping, slewing = (effects.Subject.having([force, *before]) for before in ([], ["slew_limit"]))
    assert jumping.steps < 30 < 100 < slewing.steps  # a ramp that goes on is followed all along


def test_without_forces_the_steps_are_those_of_the_bus() -> None:
    subject = effects.Subject.having(["creep"], 16)
    assert subject.steps == subject.chain.steps == 16
