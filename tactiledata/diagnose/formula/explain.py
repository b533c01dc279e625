"""The diagnosis of residuals without a gel: where they depart, which formula explains them, and what is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.extras import need_packages
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.formula.candidates import carriers
from tactiledata.diagnose.formula.open_form import OpenForm, corrected_words, find_candidates, open_form
from tactiledata.diagnose.formula.shifted import shift_carriers
from tactiledata.diagnose.formula.surface import Empirical, empirical
from tactiledata.diagnose.formula.unseen import UnseenFormula, held_out
from tactiledata.diagnose.locate.locate import LocateOptions, LocatorResults, locate
from tactiledata.diagnose.residuals.ceiling import WORTH, BlackBox, black_box
from tactiledata.diagnose.residuals.gap import Gap, gap_closed, is_improved, scatter
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.wording import gap_words, growth_words, percent
from tactiledata.diagnose.verdict import Verdict

STEPS = ("locating", "looking for a formula", "what it does for held-out groups", "the ceiling", "what is left")
"""What progress reports, in order."""
COMMON = "a common offset"
"""The locator that finds calibrations."""
UNNAMED = (
    "Structured, not named: a black box predicts part of the differences on groups that it was not trained on, and no"
    " locator says where they are."
)


@dataclass(frozen=True)
class Explanation:
    """The diagnosis of residuals: what locators find, the formula, and what the formula does for unseen groups.

    Parameters
    ----------
    located : LocatorResults
        Results of the locators on the residuals.
    form : OpenForm, optional
        ``None`` where the locators find no structure.
    held : UnseenFormula, optional
        Residuals with and without the formula, on groups that had no part in it; ``None`` without terms.
    gap : Gap, optional
        Share of the gap between error and floor that the formula closes on these groups.
    floor_is : str
        What the gap's floor is, in words.
    ceiling : BlackBox
        What boosted trees predict of groups that they were not trained on.
    left_over : LocatorResults, optional
        Results of the locators on what the formula leaves; ``None`` without terms.
    surface : Empirical, optional
        A smooth surface over two covariates, for structure without a formula.
    """

    located: LocatorResults
    form: OpenForm | None
    held: UnseenFormula | None
    gap: Gap | None
    floor_is: str
    ceiling: BlackBox
    left_over: LocatorResults | None
    surface: Empirical | None

    @property
    def is_found(self) -> bool:
        """Whether there is structure: a locator is certain of it, or a black box predicts it."""
        return self.located.is_structured or self.ceiling.is_certain

    @property
    def is_held(self) -> bool:
        """Whether the formula improves groups that had no part in it, certainly and by at least `WORTH`."""
        if self.held is None or self.gap is None:
            return False
        is_enough = not np.isfinite(self.gap.closed) or self.gap.closed >= WORTH
        return is_enough and is_improved(self.held.squares_before, self.held.squares_after)

    @property
    def answer(self) -> Verdict:
        """The verdict on these residuals."""
        certain = [name for name in self.located.p if self.located.is_certain(name)]
        if certain in ([], [COMMON]) and not self.is_held:
            if self.ceiling.is_certain:
                return Verdict.STRUCTURED_NOT_NAMED
            return Verdict.CALIBRATION if certain else Verdict.NOTHING_FOUND
        if self.left_over is None or not self.is_held:
            return Verdict.NOT_EXPLAINED
        return Verdict.PARTLY_EXPLAINED if self.left_over.is_structured else Verdict.EXPLAINED

    def sentences(self) -> list[str]:
        """Return the diagnosis in sentences: the verdict, where it shows, how far the formula holds, what is left."""
        if self.form is None:
            return [*([UNNAMED] if self.ceiling.is_certain else self.located.sentences()), _ceiling(self.ceiling)]
        # the verdict
        unheld = " The best formula does not hold on groups that had no part in it." if self.form.terms else ""
        first = {
            Verdict.CALIBRATION: "A calibration is off, and nothing else is found: a common offset (zero) or scale.",
            Verdict.STRUCTURED_NOT_NAMED: UNNAMED,
            Verdict.EXPLAINED: f"Something is missing, and a formula explains it: {self.form.words}.",
            Verdict.PARTLY_EXPLAINED: f"Something is missing; a formula explains a part of it: {self.form.words}.",
            Verdict.NOT_EXPLAINED: f"Something is missing, and no short formula explains it.{unheld}",
        }[self.answer]
        # the formula with its definitions, then what the locators find
        residuals = self.located.projection.residuals
        shown = self.form.terms and self.is_held
        corrected = corrected_words(self.form, residuals.components, residuals.units) if shown else []
        definitions = [f"Here {definition}." for definition in self.form.definitions] if corrected else []
        sentences = [first, *(f"All refitted together: {equation}." for equation in corrected), *definitions]
        sentences += self.located.sentences()
        # how far the formula holds on unseen groups, beside the black box, and what is left
        if self.gap is not None and self.form.terms:
            sentences.append(_gap(self.gap, self.floor_is))
        sentences.append(_ceiling(self.ceiling))
        if self.left_over is not None and self.is_held:
            left = "structure is left" if self.left_over.is_structured else "no structure is left"
            sentences.append(f"After the formula {left}.")
        return [*sentences, *([self.surface.words] if self.surface is not None else [])]


def explain(
    residuals: Residuals,
    options: LocateOptions,
    time: str | None = None,
    scales: Mapping[str, float] | None = None,
    signatures: Mapping[str, Array] | None = None,
    progress: Progress = no_progress,
    located: LocatorResults | None = None,
    ceiling: BlackBox | None = None,
) -> Explanation:
    """Return the diagnosis of residuals: located structure, a formula for it, and its worth on unseen groups.

    Parameters
    ----------
    residuals : Residuals
    options : LocateOptions
        How to locate; its noise decides the floor of the gap, its seed draws folds, halves and sign flips.
    time : str, optional
        Covariate that is the time inside a trajectory; without it no term fades with time.
    scales : dict, covariate -> float, optional
        What a covariate is divided by in a formula, in its own unit; by default a round number near its largest size.
    signatures : dict, name -> (n, k), optional
        Whitened fields of known effects, with which the formula is compared.
    progress : Progress
        Called with the number of finished steps, the number of all steps and the name of the step that begins.
    located : LocatorResults, optional
        Results of the locators on these residuals with these options, where they are known already.
    ceiling : BlackBox, optional
        The black box of the same residuals and seed, where it is known already.

    Raises
    ------
    TactileDataError
        Too few units of exchange, or scikit-learn is not installed.
    """
    need_packages("a diagnosis", "sklearn")

    def begin(step: int) -> None:
        progress(step, len(STEPS), STEPS[step])

    begin(0)
    if located is None:
        located = locate(residuals, options)
    # structure is explained by a formula, which is tested on groups that had no part in it
    form, held, gap, left_over = None, None, None, None
    floor_is = "the noise" if options.noise is not None else "the scatter from row to row"
    if located.is_structured:
        begin(1)
        carried = [*carriers(residuals), *shift_carriers(residuals)]
        form = open_form(residuals, signatures, scales, time, options.seed, carried)
        if form.terms:
            begin(2)
            held = held_out(residuals, find_candidates(residuals, scales, time, carried), options.seed)
            floor = 1.0 if options.noise is not None else scatter(held.after, residuals.starts)
            if not np.isfinite(floor):
                floor, floor_is = 0.0, "zero, as groups of one or two rows do not show the noise"
            gap = gap_closed(held.squares_before, held.squares_after, held.counts, floor, options.seed)
    # a black box shows how much could be explained at all
    begin(3)
    if ceiling is None:
        ceiling = black_box(located.projection, options.seed)
    # what the formula leaves, and a surface for structure that is left
    begin(4)
    if form is not None and form.terms:
        explained = residuals.with_fields(form.fields)
        left_over = locate(explained.with_values(project(explained).left), options)
    surface = _surface(left_over or located, options.seed) if located.is_structured else None
    progress(len(STEPS), len(STEPS), "done")
    return Explanation(located, form, held, gap, floor_is, ceiling, left_over, surface)


def _surface(located: LocatorResults, seed: int) -> Empirical | None:
    """Return a surface over the two covariates along which parameters drift most; ``None`` if it explains little."""
    if not located.is_structured:
        return None
    covariates = located.projection.residuals.covariates
    strongest = list(dict.fromkeys(drift.covariate for drift in located.drifts if drift.covariate in covariates))
    if len(strongest) < 2:
        return None
    surface = empirical(located.projection, (strongest[0], strongest[1]), seed)
    return surface if surface is not None and surface.explained >= WORTH else None


def _gap(gap: Gap, floor_is: str) -> str:
    if not np.isfinite(gap.closed):
        return f"On groups that had no part in it the error is already at its floor, {floor_is}."
    if gap.closed < 0 and percent(-gap.closed) != percent(0.0):
        return (
            f"On groups that had no part in it the formula does not hold: the gap between the error and {floor_is}"
            f" grows by {growth_words(gap)}."
        )
    return (
        f"On groups that had no part in it the formula closes {gap_words(gap, True)} of the gap between the error and"
        f" {floor_is}."
    )


def _ceiling(ceiling: BlackBox) -> str:
    if ceiling.explained < WORTH:
        return "A black box, boosted trees on all covariates, explains nothing of groups that it was not trained on."
    return (
        f"A black box, boosted trees on all covariates, explains {percent(ceiling.explained)} of the squares of groups "
        "that it was not trained on."
    )
