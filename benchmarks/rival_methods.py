"""Ways in which others would name missing physics from the same residuals, and our own; each says names, or none.

All of them know the catalogue, the gel's plays and the noise of the frames, and all fit E, nu, mu and an offset of each
trajectory first. What they do not have is our rules: no errors of the simulation itself, no held-out trajectories, no
plausible ranges, no sets.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.held_out import folds_of
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.metric import best_imitation
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import Signature, effect_signatures, playable
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.residuals.learners import FOLDS
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial

Array = NDArray[np.float64]

NO_ERRORS = NumericalErrors(shape=0.0, law=0.0, shear=0.0, scatter=0.0, centre=0.0)
DECISIVE = 10.0
"""Fall of BIC that is usually called very strong."""
MOST_REFITS, MOST_STEPS = 4, 2
MODELS, INCLUDED = 20, 0.8
"""Of an ensemble, and the share of it that must hold a term."""
LEARNED_FRAMES, ALIKE, EXPLAINS = 400, 0.9, 0.1


class Predictor(Protocol):
    """What foretells a residual (n,) from what frames tell (n, k)."""

    def predict(self, told: Array) -> Array:
        """The residual of each frame."""


class Case:
    """One case, with the plain fit that the rivals share."""

    def __init__(self, cases: TouchSet, start: GelMaterial, effects: Sequence[str]) -> None:
        self.cases, self.start, self.effects = cases, start, tuple(effects)

    @cached_property
    def white(self) -> WhitenedTouches:
        """In units of the frames' noise alone."""
        return WhitenedTouches.of(self.cases, NO_ERRORS)

    def fit(self, start: Sequence[EffectSetting], kept: frozenset[Strength] = frozenset()) -> JointFit:
        """E, nu, mu, offsets and effects."""
        count = len(self.white.starts)
        model = joint_model(self.start, start, count, 0, kept or None, self.cases.box)
        return joint_fit(self.white, model)

    @cached_property
    def base(self) -> JointFit:
        """The plain fit."""
        return self.fit([])

    @cached_property
    def signatures(self) -> list[Signature]:
        """Of all effects that the touches tell enough for, about the plain fit."""
        names, _ = playable(self.white, self.effects)
        return effect_signatures(self.white, self.base.model.material, names)


def ours(case: Case) -> tuple[str, ...]:
    """`name_effects`: what is claimed, then what cannot be told from it."""
    options = NamingOptions(effects=case.effects, profile=False)
    return Answer(name_effects(case.cases, case.start, options)).candidates


def bic_ladder(case: Case) -> tuple[str, ...]:
    """Effects added one by one while BIC, of all readings, falls decisively: four refits a step."""
    readings = 6.0 * float((case.white.weights > 0).sum())

    def criterion(fit: JointFit) -> float:
        return fit.cost + len(fit.model.coordinates) * float(np.log(readings))

    best, signatures, kept = case.base, case.signatures, frozenset[Strength]()
    for _ in range(MOST_STEPS):
        ranked = sorted(screen(best.metric, best.residual_at_centre, signatures), key=lambda one: -one.score)
        others = [one for one in ranked[:MOST_REFITS] if one.effect not in best.names]
        tried = [found for one in others if (found := _with(case, best, kept, one)) is not None]
        if not tried:
            break
        found, added = min(tried, key=lambda one: criterion(one[0]))
        if criterion(best) - criterion(found) < DECISIVE:
            break
        best, kept = found, kept | added
        names = [name for name, _ in _by_name(case.signatures).items() if name not in best.names]
        signatures = effect_signatures(case.white, best.model.material, names, best.model.settings)
    return best.names


def _with(
    case: Case, fit: JointFit, kept: frozenset[Strength], added: Screened
) -> tuple[JointFit, frozenset[Strength]] | None:
    """The fit with an effect more, and that effect's strengths; ``None`` where gel and springs find no balance."""
    try:
        return case.fit([*fit.model.settings, *added.starts[0]], kept | added.strengths), added.strengths
    except UsageError:
        return None


def _by_name(signatures: Sequence[Signature]) -> dict[str, list[Signature]]:
    found: dict[str, list[Signature]] = {}
    for one in signatures:
        found.setdefault(one.effect, []).append(one)
    return found


def sparse_regression(case: Case) -> tuple[str, ...]:
    """An ensemble of thresholded least squares (pysindy): the residual against the signatures of all effects.

    What E, nu, mu and offsets can take is projected out first. A column's coefficient is in units of the noise; the
    threshold is that of the largest of as many coefficients of noise.
    """
    import pysindy

    fit, white = case.base, case.white
    own = fit.own[:, :, None] * (white.trajectory[:, None] == np.arange(len(white.starts)))[:, None, :]
    taken = np.concatenate([fit.shared, own], axis=2).reshape(-1, fit.shared.shape[2] + len(white.starts))
    basis = np.linalg.qr(taken / np.maximum(np.linalg.norm(taken, axis=0), 1e-300))[0]
    names = [one.effect for one in case.signatures for _ in one.strengths]
    columns = np.concatenate([one.field for one in case.signatures], axis=2).reshape(len(basis), -1)
    columns = columns - basis @ (basis.T @ columns)
    sizes = np.linalg.norm(columns, axis=0)
    is_seen = sizes > 1e-6 * sizes.max()
    columns, names = (
        columns[:, is_seen] / sizes[is_seen],
        [name for name, seen in zip(names, is_seen, strict=True) if seen],
    )
    target = fit.residual.reshape(-1)
    target = target - basis @ (basis.T @ target)
    threshold = float(np.sqrt(2.0 * np.log(columns.shape[1])))
    rows = np.random.default_rng(0)
    counts, total = np.zeros(len(names)), np.zeros(len(names))
    for _ in range(MODELS):
        drawn = rows.integers(len(target), size=len(target))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that leaves no term is an answer, not an accident
            model = pysindy.STLSQ(threshold=threshold, alpha=1e-2).fit(columns[drawn], target[drawn, None])
        found = np.asarray(model.coef_).reshape(-1)
        counts += found != 0
        total += np.abs(found)
    included = counts >= INCLUDED * MODELS
    order = [names[place] for place in np.argsort(-total) if included[place]]
    return tuple(dict.fromkeys(order))


def gaussian_process(case: Case) -> tuple[str, ...]:
    """A discrepancy that is smooth in what the frames tell (Kennedy and O'Hagan), named by what it is most like.

    Its lengths and sizes are those of the whole residual, also where a fold is held out.
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    def learn(told: Array, target: Array, before: Predictor | None) -> Predictor:
        if isinstance(before, GaussianProcessRegressor):
            return GaussianProcessRegressor(before.kernel_, optimizer=None).fit(told, target)
        kernel = ConstantKernel() * RBF(np.ones(told.shape[1]), (0.1, 1e3)) + WhiteKernel()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # a covariate that does not matter has no length
            return GaussianProcessRegressor(kernel, random_state=0).fit(told, target)

    return _named_by_discrepancy(case, learn, LEARNED_FRAMES)


def boosted_trees(case: Case) -> tuple[str, ...]:
    """A discrepancy that boosted trees learn from what the frames tell, named by what it is most like."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    def learn(told: Array, target: Array, _: Predictor | None) -> Predictor:
        return HistGradientBoostingRegressor(random_state=0).fit(told, target)

    return _named_by_discrepancy(case, learn)


def _named_by_discrepancy(
    case: Case, learn: Callable[[Array, Array, Predictor | None], Predictor], most_frames: int | None = None
) -> tuple[str, ...]:
    """The effect whose signatures imitate a learned discrepancy with a cosine above 0.9 beyond a refit, if any.

    Something is said to be missing where the discrepancy foretells a tenth of the residual on trajectories held out.
    ``learn`` gets what frames tell, the residual and, where a fold is held out, what was learned from all.
    """
    white, fit = case.white, case.base
    told = _told(white)
    known = white.weights > 0
    residual = white.in_newtons(white.with_own(fit.residual))
    chance = np.random.default_rng(0)
    learned = chance.permutation(np.flatnonzero(known))[:most_frames]
    groups = folds_of(len(white.starts), 0)[white.trajectory]
    discrepancy, left, whole = np.zeros_like(residual), 0.0, 0.0
    for axis in range(3):
        size = float(residual[known, axis].std()) or 1.0
        target = residual[:, axis] / size
        model = learn(told[learned], target[learned], None)
        discrepancy[:, axis] = size * model.predict(told)
        for fold in range(FOLDS):
            inside, outside = learned[groups[learned] != fold], known & (groups == fold)
            held = learn(told[inside], target[inside], model)
            left += float(((target[outside] - held.predict(told[outside])) ** 2).sum())
            whole += float((target[outside] ** 2).sum())
    if 1.0 - left / whole < EXPLAINS:
        return ()
    field = white.whiten(discrepancy)
    alike = {
        name: max(best_imitation(fit.metric, field, one.field) for one in signatures)
        for name, signatures in _by_name(case.signatures).items()
    }
    ranked = sorted(alike, key=lambda name: -alike[name])
    return tuple(name for name in ranked if alike[name] > ALIKE)[:1]


def _told(white: WhitenedTouches) -> Array:
    """Depth, place, seconds, speed, loading, radius (N, 7), each over its spread."""
    rows = []
    for case in white.touch_set.touches:
        touch = case.touch
        seconds = touch.seconds - touch.seconds[0]
        descent = np.diff(-touch.tips[:, 2], prepend=-touch.tips[0, 2])
        size = float(touch.indenter.sizes.get("radius", 3e-3))  # type: ignore[attr-defined]
        rows.append(np.column_stack([-touch.tips[:, 2], touch.tips[:, :2], seconds, touch.lateral_speed, descent,
                                     np.full(len(touch), size)]))  # fmt: skip
    told = np.concatenate(rows)
    return (told - told.mean(axis=0)) / np.maximum(told.std(axis=0), 1e-12)
