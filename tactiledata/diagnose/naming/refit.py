"""Refits of promising effects, alone and in pairs, together with material and nuisance parameters; their scores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.diagnose.naming.agreement import Agreement, agreement, strength_trend
from tactiledata.diagnose.naming.beside import pairs_in_question
from tactiledata.diagnose.naming.decide import Decision, decide
from tactiledata.diagnose.naming.error_sizes import estimated_sizes, typical_size
from tactiledata.diagnose.naming.evidence import ScoredCandidate, score_candidate
from tactiledata.diagnose.naming.held_out import GroupedCosts, HeldOutTask, held_out
from tactiledata.diagnose.naming.intervals import range_checks
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.kept_fits import FitRequest, KeptFits
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.naming.ties import ties_of_two
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError

WEAK = 0.05
"""Share of the screen's strengths from which a refit starts that did not end below the fit without the effect."""
GAINED = 1.0
"""Fall of the cost below the fit without the effect from which a refit has found something."""
PAST = ("powered", "earlier_depth", "earlier_contacts")
"""Fields of a touch that say what happened before it."""
COMPARABLE = 0.8
"""Another effect is tried in place of a named one if its score is at least this share of the named one's."""


@dataclass(frozen=True)
class Refits:
    """The refits of one set of trajectories.

    Parameters
    ----------
    whitened : WhitenedTouches
        The trajectories.
    base : JointFit
        The plain fit.
    options : NamingOptions
        Thresholds, and how many refits are made.
    progress : callable
        Called with a few words before each refit.
    reference : GroupedCosts, optional
        Held-out squares of the plain simulation with the sizes of errors that suit it best; those of ``base`` where
        ``None``.
    size_penalty : float
        By how much the logarithm of the plain simulation's likelihood is lower with the sizes of errors of these refits
        than with those that suit it best. It is subtracted, so that candidates get no evidence from the sizes alone.
    kept : KeptFits
        Makes the refits.
    runner : Scheduler
        Where several refits are made at a time; they and their results do not depend on the number of workers.
    """

    whitened: WhitenedTouches
    base: JointFit
    options: NamingOptions
    progress: Callable[[str], None]
    reference: GroupedCosts | None = None
    size_penalty: float = 0.0
    kept: KeptFits = field(default_factory=KeptFits)
    runner: Scheduler = field(default_factory=LocalScheduler)

    @property
    def thresholds(self) -> DecisionThresholds:
        """The thresholds for these trajectories."""
        return self.options.thresholds.for_data(len(self.whitened.starts), self.whitened.precision)

    def singles(self, screened: Sequence[Screened]) -> list[JointFit]:
        """Return a refit of each promising effect, the best of its starts; effects without any balance are left out.

        A refit that stays far behind that of the most promising effect ends early.
        """
        promising = [effect for effect in screened if effect.evidence > self.options.promising][
            : self.options.most_singles
        ]
        asked = [_Added(self.base, tuple(effect.starts), effect.strengths) for effect in promising]
        fits: list[JointFit] = []
        for group in (asked[:1], asked[1:]):
            fits += filter(None, self._with_added(group, _cost_to_beat(fits)))
        return fits

    def _with_added(self, asked: Sequence[_Added], to_beat: float) -> list[JointFit | None]:
        """Return the best refit of each; ``None`` where none finds a balance; ``to_beat`` as in `joint_fit`."""
        if asked:
            self.progress(f"refit {', '.join(map(str, asked))}")
        requests = [self._request(one, start, to_beat) for one in asked for start in one.starts]
        fits = iter(self._fits(requests))
        best = [
            min(filter(None, [next(fits) for _ in one.starts]), key=lambda fit: fit.cost, default=None) for one in asked
        ]
        # the fit without what is added is a special case: where a refit ends above it or there, others are tried, too
        above = [place for place, fit in enumerate(best) if fit is None or fit.cost > asked[place].near.cost - GAINED]
        others = [(place, start) for place in above for start in asked[place].other_starts]
        requests = [self._request(asked[place], start, to_beat) for place, start in others]
        for (place, _), fit in zip(others, self._fits(requests), strict=True):
            best[place] = min(filter(None, [best[place], fit]), key=lambda fit: fit.cost, default=None)
        return best

    def pairs(self, screened: Sequence[Screened], singles: Sequence[JointFit]) -> list[JointFit]:
        """Return refits of the few most promising pairs among the best singles.

        A pair is promising where a screen beside the refitted first effect gives the second one the evidence that it
        needs. The expected cost of a pair is that of the first effect less the score of the second.
        """
        best = sorted(singles, key=lambda fit: fit.cost)[: self.options.most_paired]
        kept = {effect.effect: effect.strengths for effect in screened}
        alone = {fit.names[0]: fit.model.settings for fit in singles}
        # each promising pair, from the better of its two orders, with its expected cost
        promises: dict[frozenset[str], tuple[float, _Added]] = {}
        for first in best[: self.options.most_first]:
            self.progress(f"what {first.names[0]} leaves")
            others = [fit.names[0] for fit in best if fit is not first]
            model = first.model
            signatures = effect_signatures(self.whitened, model.material, others, model.settings, model.offsets)
            for second in screen(first.metric, first.residual_at_centre, signatures):
                if second.evidence < self.thresholds.claim(second.effect):
                    continue
                key = frozenset([first.names[0], second.effect])
                cost = first.cost - second.score
                if key not in promises or cost < promises[key][0]:
                    strengths = kept[first.names[0]] | kept[second.effect]
                    promises[key] = cost, _Added(first, (second.starts[0],), strengths, alone[second.effect])
        # refits, the most promising first; another one that is hopeless beside it ends early
        chosen = sorted(promises.values(), key=lambda promise: promise[0])[: self.options.most_pairs]
        fits: list[JointFit] = []
        for group in (chosen[:1], chosen[1:]):
            fits += filter(None, self._with_added([added for _, added in group], _cost_to_beat(fits)))
        return fits

    def score_and_decide(
        self, singles: list[JointFit], pairs: list[JointFit]
    ) -> tuple[list[ScoredCandidate], Decision]:
        """Return the scores of all refits, and the answer.

        Each refit is scored by its evidence and by what it gains on held-out trajectories and indenters, in units of
        the dispersion that the best fit leaves there. Where a pair is named, refits in which another effect replaces
        one of the two are scored as well: those that explain the data as well become ties.
        """
        # held-out squares of every fit
        self.progress("held-out trajectories and indenters")
        base_out = self.reference or held_out(self.whitened, self.base, self.options.seed)
        outs = self._held_out([*singles, *pairs])
        scored, decision, score_of = self._judged(singles, pairs, base_out, outs)
        more = self._in_question(scored[: len(singles)], scored[len(singles) :])
        if more:
            pairs, outs = [*pairs, *more], [*outs, *self._held_out(more)]
            scored, decision, score_of = self._judged(singles, pairs, base_out, outs)
        best, thresholds = decision.best, self.thresholds
        if best is None or len(decision.claimed) < 2:
            return scored, decision
        # ties of a named pair
        of_single = {candidate.label: candidate for candidate in scored[: len(singles)]}
        found = self.substitutes(best.fit, [candidate.fit for candidate in of_single.values()])
        substitute_outs = self._held_out([fit for _, fit in found])
        substitutes = [
            (of_single[kept], score_of(fit, out)) for (kept, fit), out in zip(found, substitute_outs, strict=True)
        ]
        ties = ties_of_two(best, substitutes, thresholds)
        known = {frozenset(candidate.names) for candidate in scored}
        scored += [substitute for _, substitute in substitutes if frozenset(substitute.names) not in known]
        return scored, replace(decision, ties=ties)

    def _judged(
        self,
        singles: Sequence[JointFit],
        pairs: Sequence[JointFit],
        base_out: GroupedCosts,
        outs: Sequence[GroupedCosts],
    ) -> tuple[list[ScoredCandidate], Decision, Callable[[JointFit, GroupedCosts], ScoredCandidate]]:
        """Return the scores of refits, the answer without ties of two, and what scores a further refit.

        Parameters
        ----------
        base_out, outs : GroupedCosts
            Held-out squares of the plain simulation, and of each refit, singles first.
        """
        thresholds, expected = self.thresholds, self.whitened.expected
        # the dispersion that the best one leaves
        least = min((out.by_trajectory for out in (base_out, *outs)), key=np.sum)
        left = RemainingStructure.of(least, expected, [case.name for case in self.whitened.touch_set.touches])
        dispersion = max(1.0, left.dispersion)

        def score_of(fit: JointFit, out: GroupedCosts) -> ScoredCandidate:
            # what an effect explains is no error of the simulation
            size = typical_size(estimated_sizes(self.whitened, fit))
            scored = score_candidate(self.base, fit, base_out, out, float(expected.sum()), dispersion, size)
            return replace(with_penalty(scored, self.size_penalty / dispersion), trend=self.trend(fit))

        scored = [score_of(fit, out) for fit, out in zip((*singles, *pairs), outs, strict=True)]
        scored[len(singles) :] = [self._with_agreement(pair, singles) for pair in scored[len(singles) :]]
        gains = {candidate.label: candidate.gains for candidate in scored}
        decision = decide(scored[: len(singles)], scored[len(singles) :], gains, self.base.metric, left, thresholds)
        return scored, decision, score_of

    def _in_question(self, singles: Sequence[ScoredCandidate], pairs: Sequence[ScoredCandidate]) -> list[JointFit]:
        """Return refits of pairs that decide on a name and were not among the promising ones (`pairs_in_question`)."""
        asked = []
        for larger, smaller in pairs_in_question(singles, pairs, self.thresholds):
            strengths = larger.fit.model.strengths | smaller.fit.model.strengths
            asked.append(_Added(larger.fit, (smaller.fit.model.settings,), strengths))
        return [fit for fit in self._with_added(asked, np.inf) if fit is not None]

    def _with_agreement(self, pair: ScoredCandidate, singles: Sequence[JointFit]) -> ScoredCandidate:
        """Pair with the signature statistic of each effect beside the refit of the other one alone.

        It is 0 where gel and springs find no balance without the effect: its change is then not known.
        """
        alone = {fit.names[0]: fit for fit in singles}
        play, model = self.whitened.touch_set.play, pair.fit.model
        found = {}
        for name, other in (pair.names, pair.names[::-1]):
            of_other = [setting for setting in model.settings if setting.effect == other]
            try:
                gained = play(model.material, of_other, model.offsets) - play(model.material, [], model.offsets)
            except UsageError:
                found[name] = 0.0
                continue
            change = pair.fit.effect_change - self.whitened.whiten(gained)
            beside = alone[other]
            found[name] = agreement(beside.metric, change, beside.residual_at_centre).standard_errors
        return replace(pair, agreement_beside=found)

    def trend(self, fit: JointFit) -> Agreement | None:
        """Return how the strength of a single effect changes during the session; ``None`` where that is not known.

        It is known where all touches state the time since their sensor was switched on. Effects that depend on what
        happened before a touch change with time by themselves.
        """
        touches = self.whitened.touch_set.touches
        if len(fit.names) != 1 or set(EFFECTS[fit.names[0]].needs) & set(PAST):
            return None
        times = [case.touch.powered for case in touches]
        known = [float(time.mean()) for time in times if time is not None]
        if len(known) < len(touches):
            return None
        return strength_trend(
            fit.beside, fit.effect_change, fit.residual_beside, np.array(known), self.whitened.indenter
        )

    def substitutes(self, pair: JointFit, singles: Sequence[JointFit]) -> list[tuple[str, JointFit]]:
        """Return refits in which another single replaces one effect of a pair, each with the name of the kept effect.

        Refitted are those whose score beside the kept effect is at least ``COMPARABLE`` times the score of the effect
        that they replace.
        """
        kept_effects, asked = [], []
        for index, kept in enumerate(pair.names):
            alone = next(fit for fit in singles if fit.names == (kept,))
            named = pair.names[1 - index]
            others = [named, *(fit.names[0] for fit in singles if fit.names[0] not in pair.names)]
            self.progress(f"what could stand for {named}")
            model = alone.model
            signatures = effect_signatures(self.whitened, model.material, others, model.settings, model.offsets)
            scores = {effect.effect: effect for effect in screen(alone.metric, alone.residual_at_centre, signatures)}
            least = COMPARABLE * scores[named].score if named in scores else np.inf
            for name, other in scores.items():
                if name == named or other.score < least:
                    continue
                strengths = model.strengths | other.strengths
                kept_effects.append(kept)
                asked.append(_Added(alone, (other.starts[0],), strengths))
        fits = zip(kept_effects, self._with_added(asked, pair.cost), strict=True)
        return [(kept, fit) for kept, fit in fits if fit is not None]

    def _fits(self, requests: Sequence[FitRequest]) -> list[JointFit | None]:
        """Fit of each request; ``None`` where gel and springs find no balance, as with too strong an effect."""
        return self.kept.joint_fits(self.whitened, requests, self.runner)

    def _held_out(self, fits: Sequence[JointFit]) -> list[GroupedCosts]:
        """Held-out squares of each fit."""
        tasks = [HeldOutTask(self.whitened, fit, self.options.seed) for fit in fits]
        return [outcome.value for outcome in self.runner.outcomes(HeldOutTask.costs, tasks)]

    def _request(self, one: _Added, start: Sequence[EffectSetting], to_beat: float) -> FitRequest:
        """Request of a joint fit from start values of the added effect; ``to_beat`` as in `joint_fit`."""
        near = one.near.model
        settings, errors = (*near.settings, *start), len(near.errors)
        model = joint_model(near.material, settings, len(self.whitened.starts), errors, one.strengths, near.box)
        of_material_and_effects = model.vector[: 3 + len(model.coordinates)]
        model = model.at(np.concatenate([of_material_and_effects, near.errors]), near.offsets)
        return FitRequest(model, to_beat=to_beat)


@dataclass(frozen=True)
class _Added:
    """An effect that is added to a fit.

    Parameters
    ----------
    near : JointFit
        The fit. Its effects, material, contact offsets and errors of the simulation are where the refit starts.
    starts : tuple of tuples of EffectSetting
        Settings of the added effect from which refits start, the most promising first.
    strengths : frozenset of Strength
        Strengths that are free, of all effects.
    alone : tuple of EffectSetting
        Settings of the added effect where it was refitted without the others; empty where it was not.
    """

    near: JointFit
    starts: tuple[tuple[EffectSetting, ...], ...]
    strengths: frozenset[Strength]
    alone: tuple[EffectSetting, ...] = ()

    def __str__(self) -> str:
        settings = (*self.near.model.settings, *self.starts[0])
        return " with ".join(dict.fromkeys(setting.effect for setting in settings))

    @property
    def other_starts(self) -> tuple[tuple[EffectSetting, ...], ...]:
        """Return where a refit starts that found nothing from ``starts``: next to the fit, and as refitted alone."""
        weak = tuple(setting.weakened(WEAK) for setting in self.starts[0])
        return (weak, self.alone) if self.alone else (weak,)


def _cost_to_beat(fits: Sequence[JointFit]) -> float:
    """Least cost of fits whose numbers are plausible; infinite where there is none."""
    return min((fit.cost for fit in fits if not range_checks(fit)[0]), default=np.inf)


def with_penalty(candidate: ScoredCandidate, penalty: float) -> ScoredCandidate:
    """Return a candidate with less evidence; trajectories lose of it in proportion to what they contribute.

    Parameters
    ----------
    candidate : ScoredCandidate
        The candidate.
    penalty : float
        What is subtracted from its evidence, at least 0.
    """
    each = candidate.evidence_per_trajectory
    total = float(each.sum())
    share = 1.0 - min(penalty, total) / total if total > 0 else 1.0
    return replace(candidate, evidence=candidate.evidence - penalty, evidence_per_trajectory=share * each)
