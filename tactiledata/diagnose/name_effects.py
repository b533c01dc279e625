"""Naming what a simulation lacks: screen, refits, pairs, and the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.decide import Decision, decide, ties_of_two
from tactiledata.diagnose.effect_signatures import effect_signatures, playable
from tactiledata.diagnose.evidence_scale import ESTIMATED, EvidenceScale
from tactiledata.diagnose.grouped_prediction import HeldOut, held_out
from tactiledata.diagnose.identifiability import Identifiability, identifiability_of
from tactiledata.diagnose.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.joint_model import joint_model
from tactiledata.diagnose.judge import Judged, judge, range_checks
from tactiledata.diagnose.left_over import LeftOver
from tactiledata.diagnose.plain_fit import plain_fit
from tactiledata.diagnose.profiled_interval import Interval, intervals
from tactiledata.diagnose.screen import Screened, screen
from tactiledata.diagnose.strength import Strength
from tactiledata.diagnose.touch_case import CaseSet
from tactiledata.diagnose.whitened_cases import NumericalErrors, WhitenedCases
from tactiledata.effects.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.material import GelMaterial

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NamingOptions:
    """How to look.

    Parameters
    ----------
    effects : names of candidates; all of the catalogue where ``None``
    errors : NumericalErrors
    scale : EvidenceScale
    promising : float
        Logarithm of the first-order Bayes factor from which an effect is refitted.
    most_singles, most_paired, most_first, most_pairs : int
        At most so many are refitted; of the best so many, pairs are thought of, beside the best so many; so many pairs
        are refitted.
    pairs : bool
    robust : bool
        Whether frames that lie far off count for less (Huber).
    profile : bool
        Whether intervals of what is claimed come from the profile of the likelihood; from its curvature otherwise.
    seed : int
        Of the folds.
    """

    effects: tuple[str, ...] | None = None
    errors: NumericalErrors = field(default_factory=NumericalErrors)
    scale: EvidenceScale = ESTIMATED
    promising: float = 0.0
    most_singles: int = 8
    most_paired: int = 6
    most_first: int = 2
    most_pairs: int = 3
    pairs: bool = True
    robust: bool = False
    profile: bool = True
    seed: int = 0


@dataclass(frozen=True)
class Naming:
    """Everything that was found on the way.

    Parameters
    ----------
    cases : WhitenedCases
    base : JointFit
        Of the plain simulation.
    intervals_before, intervals : tuple of Interval
        Of E, nu, mu in the plain fit; of these and the effects' numbers in the best one.
    identifiable : Identifiability
        What these trajectories could tell at all.
    screened : list of Screened
    judged : list of Judged
        Singles and pairs that were refitted.
    decision : Decision
    not_tried : effects that the touches do not tell enough for
    """

    cases: WhitenedCases
    base: JointFit
    intervals_before: tuple[Interval, ...]
    intervals: tuple[Interval, ...]
    identifiable: Identifiability
    screened: list[Screened]
    judged: list[Judged]
    decision: Decision
    not_tried: tuple[str, ...]


def name_effects(
    cases: CaseSet,
    material: GelMaterial,
    options: NamingOptions | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Naming:
    """What the simulation lacks.

    Parameters
    ----------
    material : GelMaterial
        Where the fits begin, as a plain calibration found it.

    Raises
    ------
    TactileDataError
        Too few trajectories, or frames.
    """
    chosen = options or NamingOptions()
    cases.need_cases()
    white = WhitenedCases.of(cases, chosen.errors)
    progress("plain fit")
    base = plain_fit(white, material)
    if chosen.robust:
        white = white.trusting(_huber(base.residual))
        base = plain_fit(white, base.model.material)
    numerical = white.numerical(base.model.material, base.model.offsets)
    base = joint_fit(white, numerical, base.model)
    names, not_tried = playable(white, chosen.effects)
    progress("screen")
    signatures = effect_signatures(white, base.model.material, names, offsets=base.model.offsets)
    screened = screen(base.metric, base.undone, signatures)
    fits = Refits(white, numerical, base, chosen, progress)
    singles = fits.singles(screened)
    pairs = fits.pairs(screened, singles) if chosen.pairs else []
    judged, decision = fits.decided(singles, pairs)
    progress("intervals")
    claimed = decision.best is not None and not decision.objections
    best = decision.best.fit if decision.best is not None else base
    before, after = (
        intervals(white, fit, numerical, max(1.0, decision.left.dispersion), chosen.profile and claimed)
        for fit in (base, best)
    )
    identifiable = identifiability_of(base.metric, signatures, tuple(not_tried), names)
    return Naming(white, base, before, after, identifiable, screened, judged, decision, tuple(not_tried))


def _huber(residual: Array, turn: float = 2.0) -> Array:
    """Square roots of Huber's weights (N,) of frames: 1 up to ``turn`` times the usual size of a residual."""
    size = np.sqrt((residual**2).mean(axis=1))
    usual = max(float(np.median(size)), 1e-300)
    return np.sqrt(np.minimum(1.0, turn * usual / np.maximum(size, 1e-300)))


@dataclass(frozen=True)
class Refits:
    """Refits of one set of trajectories.

    Parameters
    ----------
    white : WhitenedCases
    numerical : (N, 6, e)
    base : JointFit
    options : NamingOptions
    progress : callable
    """

    white: WhitenedCases
    numerical: Array
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
                if second.evidence < self.options.scale.claim:
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

    def decided(self, singles: list[JointFit], pairs: list[JointFit]) -> tuple[list[Judged], Decision]:
        """All refits, judged, and the answer."""
        seed, scale = self.options.seed, self.options.scale
        self.progress("held-out trajectories and indenters")
        base_out = held_out(self.white, self.base, seed)
        outs: list[HeldOut] = [held_out(self.white, fit, seed) for fit in (*singles, *pairs)]
        expected = self.white.expected
        least = min((out.by_trajectory for out in (base_out, *outs)), key=np.sum)
        left = LeftOver.of(least, expected, [case.name for case in self.white.cases.cases])
        dispersion = max(1.0, left.dispersion)

        def judged_of(fit: JointFit, out: HeldOut) -> Judged:
            return judge(self.base, fit, base_out, out, float(expected.sum()), dispersion)

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
        errors = self.numerical.shape[2]
        model = joint_model(from_there.material, start, len(self.white.starts), errors, kept, from_there.box)
        told = model.vector[: 3 + len(model.coordinates)]
        model = model.at(np.concatenate([told, from_there.errors]), from_there.offsets)
        try:
            return joint_fit(self.white, self.numerical, model, to_beat=to_beat)
        except UsageError:
            return None
