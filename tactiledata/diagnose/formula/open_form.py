"""Open form: a formula of few dimensionless terms for what a simulation lacks, with its coefficients and intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.formula.candidates import Candidates, Carrier, carriers
from tactiledata.diagnose.formula.likeness import Likeness, likenesses
from tactiledata.diagnose.formula.select import Accepted, choose
from tactiledata.diagnose.formula.terms import atoms
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.slopes import Change, refitted
from tactiledata.diagnose.residuals.wording import percent, rounded


@dataclass(frozen=True)
class Term:
    """A term of an open form.

    Parameters
    ----------
    carrier : str
        Name of what changes: a parameter (by a share) or a component.
    term : str
        Dimensionless term that multiplies the carrier.
    coefficient, half_width : float
        Coefficient and half of its 95 % interval; dimensionless for a parameter, else in the component's unit.
    inclusion : float
        Share of halves of the trajectories that choose the term, or one that is the same in these data.
    p : float
        p-value against all candidates together, after the terms before it.
    alike : tuple of str
        Names of candidates that these data cannot tell from the term.
    words : str
        The term in words.
    """

    carrier: str
    term: str
    coefficient: float
    half_width: float
    inclusion: float
    p: float
    alike: tuple[str, ...]
    words: str


@dataclass(frozen=True)
class OpenForm:
    """A sum of terms that explains residuals, with everything needed to compute and to judge it.

    Parameters
    ----------
    terms : tuple of Term
        In the order in which they were accepted; empty where no candidate is certain.
    fields : dict, term -> (n, k)
        Whitened fields of the terms with coefficient 1.
    fitted : (n, k)
        Sum of the fields times their coefficients.
    candidates : int
        Number of candidates that were tried.
    false_terms : float
        Upper bound of the expected number of false terms.
    behaves_like : tuple of Likeness
        Known effects whose signatures the sum resembles, the nearest first.
    beside : tuple of Change
        By how much the shared parameters move when they are refitted together with the terms.
    words : str
        The formula in words.
    definitions : tuple of str
        How the terms are computed, in words.
    """

    terms: tuple[Term, ...]
    fields: dict[str, Array]
    fitted: Array
    candidates: int
    false_terms: float
    behaves_like: tuple[Likeness, ...]
    beside: tuple[Change, ...]
    words: str
    definitions: tuple[str, ...] = ()


def open_form(
    residuals: Residuals,
    signatures: Mapping[str, Array] | None = None,
    scales: Mapping[str, float] | None = None,
    time: str | None = None,
    seed: int = 0,
    carried: Sequence[Carrier] | None = None,
) -> OpenForm:
    """Return a sparse formula of the residuals; without terms where no candidate is stable and certain.

    Parameters
    ----------
    residuals : Residuals
    signatures : dict, name -> (n, k), optional
        Whitened fields of known effects, with which the formula is compared.
    scales : dict, covariate -> float, optional
        What a covariate is divided by, in its own unit; by default a round number near its largest size.
    time : str, optional
        Covariate that is the time inside a trajectory; without it no term fades with time.
    seed : int
        Draws the halves of the trajectories and the sign flips.
    carried : sequence of Carrier, optional
        What a term may multiply; by default the shared parameters and the components.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    candidates = find_candidates(residuals, scales, time, carried)
    accepted, bound = choose(residuals, candidates, seed)
    return _summed(residuals, candidates, accepted, bound, signatures or {})


def find_candidates(
    residuals: Residuals,
    scales: Mapping[str, float] | None = None,
    time: str | None = None,
    carried: Sequence[Carrier] | None = None,
) -> Candidates:
    """Return the candidates of an open form. They depend on covariates and slopes, not on the residuals' values.

    Parameters
    ----------
    residuals, scales, time, carried
        As in `open_form`.
    """
    listed = carriers(residuals) if carried is None else list(carried)
    return Candidates.of(listed, atoms(residuals, scales, time))


def _summed(
    residuals: Residuals,
    candidates: Candidates,
    accepted: list[Accepted],
    bound: float,
    signatures: Mapping[str, Array],
) -> OpenForm:
    """Return the formula of the accepted candidates, all refitted together with the shared parameters."""
    fields = candidates.fields([choice.number for choice in accepted])
    if not accepted:
        words = "No formula: no term is chosen often enough by halves of the trajectories."
        return OpenForm((), {}, np.zeros_like(residuals.values), len(candidates), bound, (), (), words)
    # coefficients of the terms, and how far the shared parameters move with them
    moved = refitted(project(residuals.with_fields(fields)))
    beside, changes = tuple(moved[: -len(accepted)]), moved[-len(accepted) :]
    terms = []
    for choice, change in zip(accepted, changes, strict=True):
        name, carrier = candidates.name_of(choice.number), candidates.carrier_of(choice.number)
        equation = carrier.words(name, change.value, change.half_width, candidates.since.get(name))
        words = f"{equation}, chosen by {percent(choice.inclusion)} of random halves{_or_alike(choice.alike)}"
        interval = change.value, change.half_width
        terms.append(Term(carrier.name, name, *interval, choice.inclusion, choice.p, choice.alike, words))
    # known effects that the sum resembles
    fitted = np.stack(list(fields.values()), axis=2) @ np.array([change.value for change in changes])
    resembled = likenesses(project(residuals), fitted, signatures)
    like = next(
        (f"; it behaves like {effect.name} (cosine {effect.cosine:.2f})" for effect in resembled if effect.is_near), ""
    )
    return OpenForm(
        terms=tuple(terms),
        fields=fields,
        fitted=fitted,
        candidates=len(candidates),
        false_terms=bound,
        behaves_like=resembled,
        beside=beside,
        words=f"{'; '.join(term.words for term in terms)}{like}",
        definitions=candidates.definitions_of([choice.number for choice in accepted]),
    )


def _or_alike(alike: tuple[str, ...]) -> str:
    """Return in brackets which candidates these data cannot tell from a term; empty where there is none."""
    if not alike:
        return ""
    others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
    return f" (these data cannot tell it from {alike[0]}{others})"


DIGITS = 3
"""Significant digits of the numbers of a corrected prediction."""
OFFSET_OF, SCALE_OF = "the offset of ", "the scale of "
"""How the names of a table's parameters begin; the name of the quantity follows."""


def corrected_words(form: OpenForm, components: Sequence[str], units: Sequence[str]) -> list[str]:
    """Return the corrected prediction of each component that has a term, as an equation.

    Example: ``"corrected fz = predicted fz × (1 - 0.0712 + 0.150 × depth/(0.90 mm))"``.

    Parameters
    ----------
    form : OpenForm
    components, units : sequence of str
        Name and unit of each component of the residuals.
    """
    beside = {change.parameter.name: change.value for change in form.beside}
    equations = []
    for name, unit in zip(components, units, strict=True):
        scaled = [(term.coefficient, term.term) for term in form.terms if term.carrier == f"{SCALE_OF}{name}"]
        added = [(term.coefficient, term.term) for term in form.terms if term.carrier == name]
        shifts = [term for term in form.terms if term.carrier.startswith(f"{name} over ")]
        moved = "".join(
            f" {'+' if term.coefficient > 0 else '-'} {rounded(abs(term.coefficient), DIGITS)}"
            f"{'' if term.term == '1' else f' × {term.term}'} × slope of predicted {term.carrier}"
            for term in shifts
        )
        if not scaled and not added and not shifts:
            continue
        factor = "".join(_signed(*part) for part in [(beside.get(f"{SCALE_OF}{name}", 0.0), ""), *scaled])
        more = "".join(_signed(*part, unit=unit) for part in [*added, (beside.get(f"{OFFSET_OF}{name}", 0.0), "")])
        scale = f" × (1{factor})" if factor else ""
        equations.append(f"corrected {name} = predicted {name}{scale}{moved}{more}")
    return equations


def _signed(value: float, term: str, unit: str = "1") -> str:
    """Return a summand with its sign, as ``" + 0.150 × depth/(0.90 mm)"``; empty where the value is 0."""
    if not value:
        return ""
    size = f"{rounded(abs(value), DIGITS)}{'' if unit in ('1', '?') else f' {unit}'}"
    return f" {'+' if value > 0 else '-'} {size}{f' × {term}' if term else ''}"
