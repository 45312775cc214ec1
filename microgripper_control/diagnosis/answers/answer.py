"""From the weighed explanations to answers: verdict, candidates, stages, ambiguous groups."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from microgripper_control.diagnosis.answers.weighing import (
    MISTUNED,
    NOTHING,
    OUTSIDE,
    Explanation,
    explained,
)
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.findings import (
    EFFECTS,
    NONE,
    PARAMETERS,
    UNKNOWN,
    Candidate,
    Signature,
)
from microgripper_control.diagnosis.fits.trial import Trial, evenly, limits_of
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.effects.base import Stage
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, Setting

Weighed = Mapping[Explanation, float]
ANSWERS = {NOTHING: NONE, MISTUNED: PARAMETERS, OUTSIDE: UNKNOWN}
WORTH_NAMING = 5.0  # times as probable as without it: a further effect that is named,
TAKES_MOST = 0.5  # or a second one that is no less so, and leaves less than so much of the rest
RIVAL = 0.15  # of the chosen explanation's probability: may be it for all we know,
EQUAL = 0.8  # and what cannot be told from it, if it leaves about as much:
ALIKE = 0.5  # of the noise floor, beyond what the chosen one leaves, at most
MOST_RIVALS = 4
AT_BOUND = 1e-3  # of the range


def verdict(weighed: Weighed, pool: Pool) -> str:
    """The kind of answer that is most probable; effects that stand for each other count as one."""
    kinds = {name: weighed.get(answer, 0.0) for answer, name in ANSWERS.items()}
    if best := chosen(weighed, pool):
        first = by_importance(best, pool)[0]
        alike = [group for group in _stand_ins(weighed, pool, RIVAL) if first in group]
        led = _led(weighed, pool)
        named = {first, *(name for group in alike for name in group)} & led.keys()
        kinds[EFFECTS] = math.fsum(p for name in named for p in led[name].values())
    return max(kinds, key=lambda kind: kinds[kind])


def _led(weighed: Weighed, pool: Pool) -> dict[str, dict[Explanation, float]]:
    """The explanations by effects and their probabilities, by the effect that leads each."""
    led: dict[str, dict[Explanation, float]] = {}
    for effects, probability in weighed.items():
        if effects not in ANSWERS:
            led.setdefault(by_importance(effects, pool)[0], {})[effects] = probability
    return led


def chosen(weighed: Weighed, pool: Pool) -> Explanation:
    """Of the explanations by effects that the most probable first effect leads, the best.

    One effect may share its probability among several sets with others: the answer begins with the
    effect that stands first among the candidates. What its law leaves, not being the rig's own,
    many others could take up a little: one is named beside it only if that is worth much more, or
    if it takes most of it away. Empty if none was tried.
    """
    led = _led(weighed, pool)
    if not led:
        return frozenset()
    own = max(led.values(), key=lambda own: math.fsum(own.values()))
    best = max(own, key=lambda effects: own[effects])
    while smaller := [
        fewer
        for fewer in (best - {name} for name in best)
        if fewer in own and not _is_worth_naming(best, fewer, own, pool)
    ]:
        best = max(smaller, key=lambda effects: own[effects])
    return best


def _is_worth_naming(more: Explanation, fewer: Explanation, own: Weighed, pool: Pool) -> bool:
    """Whether an effect that one explanation has and the other has not is named."""
    if own[fewer] <= own[more] / WORTH_NAMING:
        return True
    rest = _rest(fewer, pool)
    shows = len(fewer) == 1 and rest > pool.noise_floor and own[fewer] <= own[more]
    return shows and _rest(more, pool) < TAKES_MOST * rest


def _rest(effects: Explanation, pool: Pool) -> float:
    """What an explanation leaves beyond noise, m rms, of both kinds of samples."""
    left = explained(effects, pool.tried[effects], pool)
    return evenly(*(removable(error, pool.noise_floor) for error in left))


def by_importance(effects: Explanation, pool: Pool) -> tuple[str, ...]:
    """Effects in the order of what each alone takes away, the most first."""
    return tuple(sorted(effects, key=lambda name: (_alone(name, pool), name)))


def _alone(name: str, pool: Pool) -> float:
    """m: what is left when one effect alone is added; infinite if that was not fitted."""
    trial = pool.tried.get(frozenset([name]))
    return explained(frozenset([name]), trial, pool).judged if trial else float("inf")


def candidates(
    weighed: Weighed,
    pool: Pool,
    names: Sequence[str],
    signatures: Sequence[Signature],
    model: Model,
) -> tuple[Candidate, ...]:
    """Every effect tried and the three other answers, largest probability first.

    An effect that `model` has shows its values and their intervals, another those it has alone.
    """
    answer = dict.fromkeys([*names, *ANSWERS.values()], 0.0)
    present = dict(answer)
    for explanation, probability in weighed.items():
        if explanation in ANSWERS:
            answer[ANSWERS[explanation]] += probability
            present[ANSWERS[explanation]] += probability
            continue
        answer[by_importance(explanation, pool)[0]] += probability
        for name in explanation:
            present[name] += probability
    errors = {NONE: pool.nominal.rmse, PARAMETERS: pool.refit.rmse}
    found = [
        Candidate(name, None, answer[name], present[name], errors.get(name))
        for name in ANSWERS.values()
    ]
    gap = removable(pool.refit.rmse, pool.noise_floor)
    for name in names:
        trial = pool.tried.get(frozenset([name]))
        left = removable(trial.rmse, pool.noise_floor) if trial else gap
        settings = _values(name, trial, model)
        found.append(
            Candidate(
                effect=name,
                stage=registry()[name].stage.value,
                probability=answer[name],
                present=present[name],
                rmse=trial.rmse if trial else None,
                parameters=settings,
                share=max(0.0, 1.0 - left / gap) if gap > 0.0 else 0.0,
                signatures=tuple(s for s in signatures if s.effect == name),
                note=_note(name, settings, pool),
            )
        )
    return tuple(sorted(found, key=lambda candidate: -candidate.probability))


def _values(name: str, trial: Trial | None, model: Model) -> Mapping[str, Setting]:
    if name in model.settings:
        return model.settings[name]
    return trial.model.settings[name] if trial else {}


def rivals(weighed: Weighed, pool: Pool) -> list[Trial]:
    """The explanations that are about as probable as the best, most probable first.

    The model as given is what its refit may be, so it is none beside that.
    """
    trials = {NOTHING: pool.nominal, MISTUNED: pool.refit, **pool.tried}
    order = sorted((e for e in weighed if e in trials), key=lambda e: -weighed[e])
    near = [e for e in order if weighed[e] > RIVAL * weighed[order[0]]]
    if MISTUNED in near:
        near = [e for e in near if e != NOTHING]
    return [trials[e] for e in near[:MOST_RIVALS]]


def _note(name: str, settings: Mapping[str, Setting], pool: Pool) -> str:
    """Which of the values shown stand at a bound, or why there are none."""
    if not settings:
        return pool.failures.get(name, "")
    bounds = []
    limits = limits_of(pool.evidence, [name])
    for parameter in registry()[name].parameters:
        value = settings[parameter.name].value
        for bound in limits.get((name, parameter.name), (parameter.low, parameter.high)):
            near = abs(value - bound) <= AT_BOUND * max(abs(bound), abs(value))
            if parameter.fitted and near and bound != parameter.vanishing:
                bounds.append(f"{parameter.name} at its bound {bound:g}{parameter.suffix}")
    return "; ".join(bounds)


def stages(found: Sequence[Candidate]) -> dict[str, float]:
    """The probability that the answer lies in each stage of the chain."""
    return {
        stage.value: sum(c.probability for c in found if c.stage == stage.value) for stage in Stage
    }


def ambiguous(weighed: Weighed, pool: Pool) -> tuple[tuple[str, ...], ...]:
    """Groups of effects that these recordings do not tell apart in the chosen explanation.

    A rival's law bends further than a rig's own, so what is much less probable but leaves as little
    is told apart all the same: of twelve groups that examinations had seen, the rig's own laws
    agreed in none.
    """
    return _stand_ins(weighed, pool, EQUAL)


def _stand_ins(weighed: Weighed, pool: Pool, share: float) -> tuple[tuple[str, ...], ...]:
    """Groups of effects that leave alike and of which one is `share` as probable as the other."""
    best = chosen(weighed, pool)
    least = explained(best, pool.tried[best], pool)
    groups: dict[str, set[str]] = {}
    for other, probability in weighed.items():
        if other in ANSWERS or len(other) != len(best) or probability < share * weighed[best]:
            continue
        ours, theirs = best - other, other - best
        left = explained(other, pool.tried[other], pool)
        beyond = removable(left.both, least.both)
        if len(ours) == 1 and beyond <= ALIKE * pool.noise_floor:
            groups.setdefault(next(iter(ours)), set()).update(theirs)
    return tuple((name, *sorted(rest)) for name, rest in sorted(groups.items()))
