"""A formula as a prediction to compute with: its terms, and what is refitted beside them."""

from __future__ import annotations

from collections.abc import Sequence

from tactiledata.diagnose.open_form import OpenForm
from tactiledata.diagnose.wording import rounded

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
