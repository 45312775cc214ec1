"""What one law has found, told to those that can do the same: they are weighed on equal terms.

Friction and hysteresis of the restoring force imitate each other and are told apart by size and
shape. The one that is tried later, or creeps towards the other from afar, would else look worse.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from microgripper_control.diagnosis.fits.trial import Trial, added, fitted_keys, with_guess, without
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.labour import is_costly
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.effects.memory_of_the_way import RELEASED
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model

BEHIND = 1.1  # times what the best leaves: what leaves less has found it by itself
EVALUATIONS = 20


def add_likened(pool: Pool, names: Collection[str], jobs: int) -> None:
    """Fit what is like an effect of the best explanation in its place, from where that one is.

    `names` are the effects that may be tried.
    """
    effects = added(pool.evidence, pool.leader)
    starts = [start for name in sorted(effects) for start in _in_place_of(name, pool, names)]
    tasks = [(pool.evidence, start, POLISHED, EVALUATIONS) for start in starts]
    for trial in side_by_side(refined, tasks, jobs):
        pool.add(trial)


def _in_place_of(name: str, pool: Pool, names: Collection[str]) -> Iterator[Trial]:
    """The best explanation with others for one of its effects, not fitted."""
    leader = pool.leader
    effects = added(pool.evidence, leader)
    for other in sorted(set(names) - effects):
        values = registry()[other].likened(name, leader.model.values(name), pool.evidence.scales)
        known = pool.tried.get(effects - {name} | {other})
        if not values or (known and known.both < BEHIND * leader.both):
            continue
        rest = without(leader, name)
        model = _as_released(leader.model, name, with_guess(rest.model, other, values), other)
        costs_more = is_costly(pool.evidence, model) and not is_costly(pool.evidence, leader.model)
        if costs_more and not pool.leaves_a_rest(leader):
            continue
        yield replace(rest, model=model, free=(*rest.free, *fitted_keys(model, [other])))


def _as_released(leader: Model, name: str, model: Model, other: str) -> Model:
    """The model in which the other law, too, begins a recording with or without what it held."""
    if not all(RELEASED in registry()[one].parameters for one in (name, other)):
        return model
    return model.with_values({(other, RELEASED.name): leader.value(name, RELEASED.name)})
