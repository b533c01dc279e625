"""Locate, explain by a formula, show: what any residuals can be asked without a gel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.formula.candidates import carriers
from tactiledata.diagnose.formula.open_form import OpenForm, corrected_words, find_candidates, open_form
from tactiledata.diagnose.formula.shifted import shift_carriers
from tactiledata.diagnose.formula.surface import Empirical, empirical
from tactiledata.diagnose.formula.unseen import UnseenFormula, held_out
from tactiledata.diagnose.locate.locate import LocateOptions, LocatorResults, locate
from tactiledata.diagnose.residuals.ceiling import BlackBox, black_box
from tactiledata.diagnose.residuals.gap import Gap, gap_closed, is_improved, scatter
from tactiledata.diagnose.residuals.learners import need_learning_library
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.wording import gap_words, growth_words, percent

Answer = Literal[
    "nothing found", "calibration", "structured, not named", "explained", "partly explained", "not explained"
]

STEPS = ("locating", "looking for a formula", "what it does for held-out groups", "the ceiling", "what is left")
COMMON = "a common offset"
"""The locator that finds calibrations."""
UNNAMED = (
    "Structured, not named: a black box foresees a part of groups that it has not seen, and nothing else names it."
)
WORTH = 0.02
"""Share of the squares of held-out groups from which on a formula is worth a sentence."""


@dataclass(frozen=True)
class Explanation:
    """A diagnosis of residuals.

    Parameters
    ----------
    located : LocatorResults
    form : OpenForm, optional
        ``None`` where nothing was found to be explained.
    held : UnseenFormula, optional
        With and without the formula, on groups that had no part in it.
    gap : Gap, optional
    floor_is : what the gap's floor is, in words
    ceiling : BlackBox
    left_over : LocatorResults, optional
        Of what the formula leaves.
    surface : Empirical, optional
        For structure without a formula.
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
        """Whether there is anything beside noise: what a locator is sure of, or what a black box foresees."""
        return self.located.is_structured or self.ceiling.is_certain

    @property
    def is_held(self) -> bool:
        """Whether the formula makes groups better that had no part in it, surely and by enough to be said."""
        if self.held is None or self.gap is None:
            return False
        is_enough = not np.isfinite(self.gap.closed) or self.gap.closed >= WORTH
        return is_enough and is_improved(self.held.squares_before, self.held.squares_after)

    @property
    def answer(self) -> Answer:
        """The verdict in a few words."""
        certain = [name for name in self.located.p if self.located.is_certain(name)]
        if certain in ([], [COMMON]) and not self.is_held:
            if self.ceiling.is_certain:
                return "structured, not named"
            return "calibration" if certain else "nothing found"
        if self.left_over is None or not self.is_held:
            return "not explained"
        return "partly explained" if self.left_over.is_structured else "explained"

    def sentences(self) -> list[str]:
        """For people, the answer first."""
        if self.form is None:
            return [*([UNNAMED] if self.ceiling.is_certain else self.located.sentences()), _ceiling(self.ceiling)]
        said = list(self.located.sentences())
        unheld = " The best one does not hold on groups that had no part in it." if self.form.terms else ""
        first = {
            "calibration": "A calibration is off, and nothing else is found: a common offset (zero) or scale.",
            "structured, not named": UNNAMED,
            "explained": f"Something is missing, and a formula explains it: {self.form.words}.",
            "partly explained": f"Something is missing; a formula explains a part of it: {self.form.words}.",
            "not explained": f"Something is missing, and no short formula explains it.{unheld}",
        }[self.answer]
        residuals = self.located.projection.residuals
        shown = self.form.terms and self.is_held
        corrected = corrected_words(self.form, residuals.components, residuals.units) if shown else []
        meant = [f"Here {one}." for one in self.form.definitions] if corrected else []
        said[:0] = [first, *(f"All refitted together: {one}." for one in corrected), *meant]
        if self.gap is not None and self.form.terms:
            said.append(_gap(self.gap, self.floor_is))
        said.append(_ceiling(self.ceiling))
        if self.left_over is not None and self.is_held:
            left = "structure is left" if self.left_over.is_structured else "no structure is left"
            said.append(f"After the formula {left}.")
        return [*said, *([self.surface.words] if self.surface is not None else [])]


def explain(
    residuals: Residuals,
    options: LocateOptions,
    time: str | None = None,
    scales: Mapping[str, float] | None = None,
    signatures: Mapping[str, Array] | None = None,
    tell: Progress = no_progress,
    located: LocatorResults | None = None,
) -> Explanation:
    """A diagnosis of residuals.

    Parameters
    ----------
    time, scales, signatures
        See `tactiledata.diagnose.formula.open_form.open_form`.
    tell : callable
        Told how many of the steps are done.
    located : LocatorResults, optional
        Of these residuals, with these options, where it is known already.

    Raises
    ------
    TactileDataError
        Too few units of exchange, or scikit-learn is not installed.
    """
    need_learning_library()

    def begin(step: int) -> None:
        tell(step, len(STEPS), STEPS[step])

    begin(0)
    if located is None:
        located = locate(residuals, options)
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
                floor, floor_is = 0.0, "zero, as groups of one or two rows tell no noise"
            gap = gap_closed(held.squares_before, held.squares_after, held.counts, floor, options.seed)
    begin(3)
    ceiling = black_box(located.projection, options.seed)
    begin(4)
    if form is not None and form.terms:
        explained = residuals.with_fields(form.fields)
        left_over = locate(explained.with_values(project(explained).left), options)
    surface = _surface(left_over or located, options.seed) if located.is_structured else None
    tell(len(STEPS), len(STEPS), "done")
    return Explanation(located, form, held, gap, floor_is, ceiling, left_over, surface)


def _surface(located: LocatorResults, seed: int) -> Empirical | None:
    """Over the two covariates along which parameters drift most; ``None`` where it takes nothing worth a sentence."""
    if not located.is_structured:
        return None
    covariates = located.projection.residuals.covariates
    strongest = list(dict.fromkeys(drift.covariate for drift in located.drifts if drift.covariate in covariates))
    if len(strongest) < 2:
        return None
    found = empirical(located.projection, (strongest[0], strongest[1]), seed)
    return found if found is not None and found.explained >= WORTH else None


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
        return "A black box, boosted trees on all covariates, explains nothing of groups that it has not seen."
    return (
        f"A black box, boosted trees on all covariates, explains {percent(ceiling.explained)} of the squares of groups "
        "that it has not seen."
    )
