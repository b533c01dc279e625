"""What is missing as a formula: few dimensionless terms, chosen again and again by halves of the trajectories."""

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
        What changes: a parameter (by a share) or a component.
    term : str
    coefficient, half_width : float
        With its 95 % interval; dimensionless for a parameter, else in the component's unit.
    inclusion : float
        Share of halves of the trajectories that choose it, or one that is the same in these data.
    p : float
        Against all candidates together, after the terms before it.
    alike : names of candidates that these data cannot tell from it
    words : str
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
    """The formula.

    Parameters
    ----------
    terms : in the order in which they were accepted; none where nothing is certain
    fields : dict, term -> (n, k)
        Whitened fields of the terms with coefficient 1.
    fitted : (n, k)
        Their sum, with their coefficients.
    candidates : int
        So many were tried.
    false_terms : float
        Upper bound of the expected number of false ones.
    behaves_like : known signatures that the sum resembles, the nearest first
    beside : by how much the shared parameters move when they are refitted together with the terms
    words : str
    definitions : how everything in the terms is computed, in words
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
    """A sparse formula of the residual.

    Parameters
    ----------
    signatures : dict, name -> (n, k), optional
        Whitened fields of known effects.
    scales, time
        See `tactiledata.diagnose.formula.terms.atoms`.
    carried : sequence of Carrier, optional
        By default those of the parameters and components.

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
    """What an open form of residuals chooses from: the residuals themselves are not looked at."""
    listed = carriers(residuals) if carried is None else list(carried)
    return Candidates.of(listed, atoms(residuals, scales, time))


def _summed(
    residuals: Residuals,
    candidates: Candidates,
    accepted: list[Accepted],
    bound: float,
    signatures: Mapping[str, Array],
) -> OpenForm:
    fields = candidates.fields([one.number for one in accepted])
    if not accepted:
        words = "No formula: no term is chosen often enough by halves of the trajectories."
        return OpenForm((), {}, np.zeros_like(residuals.values), len(candidates), bound, (), (), words)
    moved = refitted(project(residuals.with_fields(fields)))
    beside, changes = tuple(moved[: -len(accepted)]), moved[-len(accepted) :]
    terms = []
    for chosen, one in zip(accepted, changes, strict=True):
        name, carrier = candidates.name_of(chosen.number), candidates.carrier_of(chosen.number)
        said = carrier.words(name, one.value, one.half_width, candidates.since.get(name))
        words = f"{said}, chosen by {percent(chosen.inclusion)} of halves{_or(chosen.alike)}"
        terms.append(
            Term(carrier.name, name, one.value, one.half_width, chosen.inclusion, chosen.p, chosen.alike, words)
        )
    fitted = np.stack(list(fields.values()), axis=2) @ np.array([one.value for one in changes])
    resembled = likenesses(project(residuals), fitted, signatures)
    like = next((f"; it behaves like {one.name} (cosine {one.cosine:.2f})" for one in resembled if one.is_near), "")
    words = f"{'; '.join(term.words for term in terms)}{like}"
    meant = candidates.definitions_of([one.number for one in accepted])
    return OpenForm(tuple(terms), fields, fitted, len(candidates), bound, resembled, beside, words, meant)


def _or(alike: tuple[str, ...]) -> str:
    if not alike:
        return ""
    others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
    return f" (these data cannot tell it from {alike[0]}{others})"


DIGITS = 3
OFFSET_OF, SCALE_OF = "the offset of ", "the scale of "
"""What parameters of a table are called, before the name of the quantity."""


def corrected_words(form: OpenForm, components: Sequence[str], units: Sequence[str]) -> list[str]:
    """Of each component with a term: ``"corrected fz = predicted fz × (1 - 0.0712 + 0.150 × depth/(0.90 mm))"``."""
    beside = {one.parameter.name: one.value for one in form.beside}
    said = []
    for name, unit in zip(components, units, strict=True):
        scaled = [(term.coefficient, term.term) for term in form.terms if term.carrier == f"{SCALE_OF}{name}"]
        added = [(term.coefficient, term.term) for term in form.terms if term.carrier == name]
        shifts = [one for one in form.terms if one.carrier.startswith(f"{name} over ")]
        moved = "".join(
            f" {'+' if one.coefficient > 0 else '-'} {rounded(abs(one.coefficient), DIGITS)}"
            f"{'' if one.term == '1' else f' × {one.term}'} × slope of predicted {one.carrier}"
            for one in shifts
        )
        if not scaled and not added and not shifts:
            continue
        factor = "".join(_signed(*one) for one in [(beside.get(f"{SCALE_OF}{name}", 0.0), ""), *scaled])
        more = "".join(_signed(*one, unit=unit) for one in [*added, (beside.get(f"{OFFSET_OF}{name}", 0.0), "")])
        scale = f" × (1{factor})" if factor else ""
        said.append(f"corrected {name} = predicted {name}{scale}{moved}{more}")
    return said


def _signed(value: float, term: str, unit: str = "1") -> str:
    if not value:
        return ""
    size = f"{rounded(abs(value), DIGITS)}{'' if unit in ('1', '?') else f' {unit}'}"
    return f" {'+' if value > 0 else '-'} {size}{f' × {term}' if term else ''}"
