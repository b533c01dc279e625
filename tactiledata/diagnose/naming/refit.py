"""Effects that promise something, alone and in pairs, refitted with everything else, and judged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.decide import Decision, decide, ties_of_two
from tactiledata.diagnose.naming.evidence import ScoredCandidate, range_checks, score_candidate
from tactiledata.diagnose.naming.held_out import GroupedCosts, held_out
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError


@dataclass(frozen=True)
class Refits:
    """Refits of one set of trajectories.

    Parameters
    ----------
    white : WhitenedTouches
    simulation_error_fields : (N, 6, e)
    base : JointFit
    options : NamingOptions
    progress : callable
    """

    white: WhitenedTouches
    simulation_error_fields: Array
    base: JointFit
    options: NamingOptions
    progress: Callable[[str], None]

    def singles(self, screened: Sequence[Screened]) -> list[JointFit]:
        """Of all that promise something."""
        promising = [one for one in screened if one.evidence > self.options.promising][: self.options.most_singles]
        found = []
        for one in promising:
            self.progress(f"refit {one.effect}")
            tried = [self._fit(self.base, start, one.strengths) for start in one.starts]
            found += sorted(filter(None, tried), key=lambda fit: fit.cost)[:1]
        return found

    def pairs(self, screened: Sequence[Screened], singles: Sequence[JointFit]) -> list[JointFit]:
        """Pairs among the best singles whose second promises to explain what the first leaves: the best few, refitted.

        Scores of the second beside the refitted first, as in the first screen, say which.
        """
        best = sorted(singles, key=lambda fit: fit.cost)[: self.options.most_paired]
        kept = {one.effect: one.strengths for one in screened}
        promises: dict[frozenset[str], tuple[float, JointFit, tuple[EffectSetting, ...]]] = {}
        for first in best[: self.options.most_first]:
            self.progress(f"what {first.names[0]} leaves")
            others = [fit.names[0] for fit in best if fit is not first]
            model = first.model
            signatures = effect_signatures(self.white, model.material, others, model.settings, model.offsets)
            for second in screen(first.metric, first.undone, signatures):
                if second.evidence < self.options.scale.claim_gain:
                    continue
                key = frozenset([first.names[0], second.effect])
                cost = first.cost - second.score
                start = (*first.model.settings, *second.starts[0])
                if key not in promises or cost < promises[key][0]:
                    promises[key] = cost, first, start
        found: list[JointFit] = []
        for _, first, start in sorted(promises.values(), key=lambda one: one[0])[: self.options.most_pairs]:
            names = tuple(dict.fromkeys(setting.effect for setting in start))
            self.progress(f"refit {' with '.join(names)}")
            strengths = frozenset().union(*(kept[name] for name in names))
            to_beat = min((fit.cost for fit in found if not range_checks(fit)[0]), default=np.inf)
            fit = self._fit(first, start, strengths, to_beat)
            found += [fit] if fit is not None else []
        return found

    def decided(self, singles: list[JointFit], pairs: list[JointFit]) -> tuple[list[ScoredCandidate], Decision]:
        """All refits, judged, and the answer."""
        seed, scale = self.options.seed, self.options.scale
        self.progress("held-out trajectories and indenters")
        base_out = held_out(self.white, self.base, seed)
        outs: list[GroupedCosts] = [held_out(self.white, fit, seed) for fit in (*singles, *pairs)]
        expected = self.white.expected
        least = min((out.by_trajectory for out in (base_out, *outs)), key=np.sum)
        left = RemainingStructure.of(least, expected, [case.name for case in self.white.touch_set.touches])
        dispersion = max(1.0, left.dispersion)

        def judged_of(fit: JointFit, out: GroupedCosts) -> ScoredCandidate:
            return score_candidate(self.base, fit, base_out, out, float(expected.sum()), dispersion)

        judged = [judged_of(fit, out) for fit, out in zip((*singles, *pairs), outs, strict=True)]
        gains = {one.label: one.gains for one in judged}
        decision = decide(judged[: len(singles)], judged[len(singles) :], gains, self.base.metric, left, scale)
        best = decision.best
        if decision.verdict != "named" or best is None or len(best.names) == 1:
            return judged, decision
        of_one = {one.label: one for one in judged[: len(singles)]}
        twins = [
            (of_one[stays], judged_of(fit, held_out(self.white, fit, seed)))
            for stays, fit in self.twins(best.fit, [one.fit for one in of_one.values()])
        ]
        ties = ties_of_two(best, twins, scale)
        known = {frozenset(one.names) for one in judged}
        judged += [twin for _, twin in twins if frozenset(twin.names) not in known]
        return judged, replace(decision, ties=ties, verdict="one of a set" if ties else "named")

    def twins(self, pair: JointFit, singles: Sequence[JointFit]) -> list[tuple[str, JointFit]]:
        """Refits in which another single stands for one of two effects, each under the name of the one that stays.

        Of those whose score beside it is about as good.
        """
        found = []
        for place, stays in enumerate(pair.names):
            alone = next(fit for fit in singles if fit.names == (stays,))
            named = pair.names[1 - place]
            others = [named, *(fit.names[0] for fit in singles if fit.names[0] not in pair.names)]
            self.progress(f"what could stand for {named}")
            model = alone.model
            signatures = effect_signatures(self.white, model.material, others, model.settings, model.offsets)
            scores = {one.effect: one for one in screen(alone.metric, alone.undone, signatures)}
            least = self.options.scale.as_good * scores[named].score if named in scores else np.inf
            for name, other in scores.items():
                if name == named or other.score < least:
                    continue
                strengths = model.strengths | other.strengths
                fit = self._fit(alone, (*model.settings, *other.starts[0]), strengths, pair.cost)
                found += [(stays, fit)] if fit is not None else []
        return found

    def _fit(
        self, near: JointFit, start: Sequence[EffectSetting], kept: frozenset[Strength], to_beat: float = np.inf
    ) -> JointFit | None:
        """From effects, and from all else as another fit has it; see `joint_fit`.

        None where gel and springs find no balance: an effect so strong that it cannot be played is no candidate.
        """
        from_there = near.model
        errors = self.simulation_error_fields.shape[2]
        model = joint_model(from_there.material, start, len(self.white.starts), errors, kept, from_there.box)
        told = model.vector[: 3 + len(model.coordinates)]
        model = model.at(np.concatenate([told, from_there.errors]), from_there.offsets)
        try:
            return joint_fit(self.white, self.simulation_error_fields, model, to_beat=to_beat)
        except UsageError:
            return None
