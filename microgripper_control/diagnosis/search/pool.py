"""Everything that was tried, and what follows from all of it together."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.data.grid import NO_GRID, Grid, matters, noise_under, refuted
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.fits.credibility import incredible
from microgripper_control.diagnosis.fits.trial import Trial, added
from microgripper_control.effects.registry import registry

UNEXPLAINED = 0.3  # of the noise floor: a structured rest above it asks for another effect,
UNCLOSED = 0.1  # if it is more of the gap than a law leaves that is right but not the rig's own


@dataclass
class Pool:
    """Everything that was tried, and the evidence the last fits were made on."""

    evidence: Evidence
    nominal: Trial
    refit: Trial
    tried: dict[frozenset[str], Trial] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)  # effect: why it could not be tried
    joined: set[tuple[frozenset[str], str]] = field(default_factory=set)  # beside what, and what
    coloured: float = 0.0  # m, of what the best leaves that is noise though samples tell the next

    @property
    def own(self) -> frozenset[str]:
        """The effects that the nominal model has already."""
        return frozenset(self.nominal.effects)

    @property
    def noise_floor(self) -> float:
        """m: the innovation of whichever explanation leaves the least, rounding taken away.

        What a law leaves at each step or turn of the voltage is new to the samples before, but it
        is no noise: the median passes it over. On a grid coarser than the noise most readings bring
        nothing new, and the median would pass over the noise as well.
        """
        trials = [self.nominal, self.refit, *self.tried.values()]
        best = sorted(trials, key=lambda trial: trial.rmse)[:3]
        usual = max(min(trial.quietest for trial in best), self.evidence.grid.rounding)
        if usual < self.grid.step:
            usual = np.inf
        white = min(usual, *(trial.noise_floor for trial in best))
        return noise_under(max(white, self.coloured), self.grid)

    @property
    def grid(self) -> Grid:
        """The grid that the readings lie on, if that is known or was tried; NO_GRID if not."""
        tried = any(is_read_off(name) for added in self.tried for name in added)
        return self.evidence.grid if tried or self.evidence.rounded else NO_GRID

    def add(self, trial: Trial) -> None:
        """Keep a trial unless a better one of the same effects is there."""
        effects = added(self.evidence, trial)
        if not np.isfinite(trial.both):
            self._failed(effects, "diverges on the samples that judge it")
            return
        if name := incredible(self.evidence, trial):
            before = f"{name.replace('_', ' ')} from before the recordings"
            self._failed(effects, f"{before} would have to do most of it")
            return
        known = self.tried.get(effects)
        if effects and (known is None or trial.both < known.both):
            self.tried[effects] = trial

    def drop_idle_grid(self) -> None:
        """Forget a grid that some explanation refutes, or that hardly adds to the noise."""
        chosen = [added for added in self.tried if any(is_read_off(name) for name in added)]
        others = [t.fitted_rmse for added, t in self.tried.items() if added not in chosen]
        readings = [recording.measured for recording in self.evidence.fitted]
        if refuted(self.grid, min(others, default=np.inf), readings):
            why = "the readings follow a model too closely"
        elif not matters(self.grid, self.noise_floor):
            why = f"steps of {quantity(self.grid.step, 'm')} hardly add to the noise"
        else:
            return
        for effects in chosen:
            self._failed(effects, why)
            del self.tried[effects]

    def _failed(self, effects: frozenset[str], why: str) -> None:
        if len(effects) == 1:
            (effect,) = effects
            self.failures[effect] = why

    @property
    def closest(self) -> Trial:
        """What leaves the least where it was fitted, of what does no harm where it is judged."""
        sound = [trial for trial in self.tried.values() if trial.rmse < self.refit.rmse]
        return min([self.refit, *sound], key=lambda trial: trial.fitted_rmse)

    @property
    def leader(self) -> Trial:
        """The explanation that leaves the least, or the refit."""
        return min([self.refit, *self.tried.values()], key=lambda trial: trial.both)

    def may_gain(self, leader: Trial, name: str) -> bool:
        """Whether an effect that joins a leader may still leave less than what is known of both.

        A fit can always leave what one of them does alone: where it left more it went astray, and
        may not from the other's side.
        """
        beside = added(self.evidence, leader)
        if name in beside or (beside, name) in self.joined:
            return False
        both = beside | {name}
        known = self.tried.get(both)
        fewer = [self.tried[both - {one}] for one in both if both - {one} in self.tried]
        return known is None or any(known.fitted_rmse > trial.fitted_rmse for trial in fewer)

    def best(self, size: int, count: int) -> list[Trial]:
        """The explanations with `size` effects that leave the least, best first."""
        trials = [trial for effects, trial in self.tried.items() if len(effects) == size]
        return sorted(trials, key=lambda trial: trial.both)[:count]

    def closed(self, trial: Trial) -> float:
        """The share of the gap, as an error, that an explanation closes."""
        gap = removable(self.refit.both, self.noise_floor)
        return 1.0 - removable(trial.both, self.noise_floor) / gap if gap > 0.0 else 0.0

    def leaves_a_rest(self, trial: Trial) -> bool:
        """Whether an explanation leaves more than noise."""
        floor = self.noise_floor
        return removable(trial.both, floor) > UNEXPLAINED * floor

    def leaves_more(self, trial: Trial) -> bool:
        """Whether an explanation leaves more than a right law would."""
        floor = self.noise_floor
        of_the_gap = UNCLOSED * removable(self.refit.both, floor)
        return self.leaves_a_rest(trial) and removable(trial.both, floor) > of_the_gap

    @property
    def unexplained(self) -> bool:
        """Whether even the best explanation by one effect, or a refit, leaves more than that."""
        return self.leaves_more((self.best(1, 1) or [self.refit])[0])


def strongest(names: Collection[str], pool: Pool) -> list[str]:
    """Those of some effects that were tried by themselves, in the order of what they closed."""
    alone = pool.best(1, len(pool.tried))
    return [name for trial in alone for name in added(pool.evidence, trial) if name in names]


def is_read_off(effect: str) -> bool:
    """Whether an effect is read off the recordings and not fitted."""
    return registry()[effect].read_off
