"""What an open form chooses from: a carrier with a unit, times products of up to two dimensionless atoms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.formula.terms import Atom, Since
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import Contributions, along, joined_refits
from tactiledata.diagnose.residuals.wording import quantity, with_interval

CONSTANT = "1"
"""The term of a carrier that is alone."""


@dataclass(frozen=True)
class Carrier:
    """What a dimensionless term multiplies.

    Parameters
    ----------
    name : str
        A parameter, which then changes by a share of itself, or a component, to which something is added.
    field : (n, k)
        Whitened change of the simulation where the term is 1 and its coefficient 1 ``unit``.
    unit : str
        Of the coefficient: ``"1"`` for a share.
    shifted : str
        The covariate by whose shift it changes; empty where none is shifted.
    definition : str
        How the field of a shift is computed.
    """

    name: str
    field: Array
    unit: str
    shifted: str = ""
    definition: str = ""

    def words(self, term: str, value: float, half_width: float, since: Since | None = None) -> str:
        """``"E (1 + 0.081 ± 0.010 × log10(speed/(1.0 mm/s)))"``, or ``"fx + 0.30 ± 0.05 N × …"``.

        Parameters
        ----------
        term : str
        value, half_width : float
            The coefficient and half of its 95 % interval, in the carrier's unit.
        since : Since, optional
            Where the term is the time since the last step of a covariate: a component then creeps.
        """
        if self.shifted:
            # below a contact that was found too early the prediction bends: its slope is no measure of how far
            is_exact = value > 0
            size = with_interval(abs(value), half_width, self.unit)
            size = size if is_exact else f"about {quantity(abs(value), self.unit)}"
            of = self.name.removesuffix(f" over {self.shifted}")
            times = "" if term == CONSTANT else f" × {term}"
            return f"{of} as predicted where {self.shifted} is ({size}){times} {'larger' if is_exact else 'smaller'}"
        if self.unit == "1":
            sign = "+" if value > 0 else "-"
            return f"{self.name} (1 {sign} ({with_interval(abs(value), half_width, '1')}) × {term})"
        if since is not None:
            rate = with_interval(abs(value), half_width, f"{self.unit}/{since.unit}")
            return f"{self.name} creeps by {'' if value > 0 else '-'}({rate}) after each step of {since.covariate}"
        sign = "plus" if value > 0 else "minus"
        return f"{self.name} {sign} ({with_interval(abs(value), half_width, self.unit)}) × {term}"


def carriers(residuals: Residuals) -> list[Carrier]:
    """Shared parameters whose value is known, by shares; and every component, by its unit."""
    listed = []
    for place in residuals.tested:
        parameter = residuals.parameters[place]
        if np.isfinite(parameter.value) and parameter.value != 0 and np.any(residuals.slopes[:, :, place]):
            listed.append(Carrier(parameter.name, residuals.slopes[:, :, place] * parameter.value, "1"))
    width = len(residuals.components)
    deviations = np.ones(width) if residuals.deviations is None else residuals.deviations
    units = residuals.units or ("times the noise",) * width
    for column, name in enumerate(residuals.components):
        field = np.zeros_like(residuals.values)
        field[:, column] = 1.0 / deviations[column]
        listed.append(Carrier(name, field, units[column]))
    return listed


@dataclass(frozen=True)
class Candidates:
    """All products of carriers and terms.

    Parameters
    ----------
    carriers : c of them
    names, complexities : m terms
    terms : (n, m)
    definitions : dict, term -> how the atoms in it are computed
    since : dict, term -> of which covariate's last step it is the time
    """

    carriers: tuple[Carrier, ...]
    names: tuple[str, ...]
    complexities: tuple[int, ...]
    terms: Array
    definitions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    since: Mapping[str, Since] = field(default_factory=dict)

    @classmethod
    def of(cls, carriers: Sequence[Carrier], atoms: Sequence[Atom]) -> Candidates:
        """Atoms, and their products of degree two; products that repeat one another are left out."""
        names, complexities = [one.name for one in atoms], [one.complexity for one in atoms]
        columns = [one.values for one in atoms]
        meant: dict[str, tuple[str, ...]] = {one.name: (one.definition,) for one in atoms}
        for first, one in enumerate(atoms):
            for other in atoms[first:]:
                product = one.values * other.values
                if np.ptp(product) <= 0 or np.array_equal(product, one.values) or np.array_equal(product, other.values):
                    continue
                parts = (one.definition, other.definition)
                names.append(f"{one.name} × {other.name}" if other is not one else f"{one.name}^2")
                meant[names[-1]] = tuple(dict.fromkeys(parts))
                complexities.append(one.complexity + other.complexity)
                columns.append(product)
        if any(carrier.shifted for carrier in carriers):
            names, complexities = [CONSTANT, *names], [0, *complexities]
            columns = [np.ones(len(carriers[0].field)), *columns]
        matrix = np.column_stack(columns) if columns else np.zeros((len(carriers[0].field), 0))
        since = {one.name: one.since for one in atoms if one.since is not None}
        return cls(tuple(carriers), tuple(names), tuple(complexities), matrix, meant, since)

    def part(self, rows: NDArray[np.bool_]) -> Candidates:
        """The same candidates in the frames of a mask (n,)."""
        kept = tuple(Carrier(one.name, one.field[rows], one.unit, one.shifted, one.definition) for one in self.carriers)
        return Candidates(kept, self.names, self.complexities, self.terms[rows], self.definitions, self.since)

    def __len__(self) -> int:
        return len(self.carriers) * len(self.names)

    def carrier_of(self, number: int) -> Carrier:
        """Carrier of a candidate."""
        return self.carriers[number // len(self.names)]

    def name_of(self, number: int) -> str:
        """Term of a candidate."""
        return self.names[number % len(self.names)]

    def definitions_of(self, numbers: Sequence[int]) -> tuple[str, ...]:
        """How the atoms are computed that the terms of some candidates are made of, each once."""
        parts = [part for number in numbers for part in self.definitions.get(self.name_of(number), ())]
        parts += [meant for number in numbers if (meant := self.carrier_of(number).definition)]
        return tuple(dict.fromkeys(parts))

    def full_name(self, number: int) -> str:
        """Carrier and term of a candidate."""
        return f"{self.carrier_of(number).name}: {self.name_of(number)}"

    def complexity_of(self, number: int) -> int:
        """Of a candidate."""
        return self.complexities[number % len(self.names)]

    def field(self, number: int) -> Array:
        """Whitened field (n, k) of a candidate with coefficient 1."""
        return self.carrier_of(number).field * self.terms[:, number % len(self.names), None]

    def fields(self, numbers: Sequence[int]) -> dict[str, Array]:
        """Whitened fields of several candidates by their full names."""
        return {self.full_name(number): self.field(number) for number in numbers}

    def scores(self, projection: ProjectedResiduals) -> Contributions:
        """Contributions of the units of exchange to all candidates' scores."""
        found = [along(projection, one.field, self.terms) for one in self.carriers]
        return Contributions(
            np.concatenate([one.by_unit for one in found], axis=1),
            np.concatenate([one.information_by_unit for one in found], axis=1),
            joined_refits([one.refit for one in found]),
        )

    @cached_property
    def sizes(self) -> Array:
        """Squared norms (m,) of the candidates' fields before anything is projected out."""
        told = np.stack([np.einsum("nk,nk->n", one.field, one.field) for one in self.carriers])
        return (told @ self.terms**2).ravel()
