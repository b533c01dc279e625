"""Candidates of an open form: a carrier with a unit, times a product of at most two dimensionless atoms."""

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
"""Name of the constant term, with which a carrier stands alone."""


@dataclass(frozen=True)
class Carrier:
    """A quantity that a dimensionless term multiplies.

    Parameters
    ----------
    name : str
        A parameter, which then changes by a share of itself; or a component, to which something is added.
    field : (n, k)
        Whitened change of the simulation where the term is 1 and its coefficient is 1 ``unit``.
    unit : str
        Unit of the coefficient; ``"1"`` for a share.
    shifted : str
        The covariate whose shift makes the change; empty where none is shifted.
    definition : str
        How the field of a shift is computed, in words.
    """

    name: str
    field: Array
    unit: str
    shifted: str = ""
    definition: str = ""

    def words(self, term: str, value: float, half_width: float, since: Since | None = None) -> str:
        """Return the carrier with one term in words.

        Examples: ``"E (1 + (0.081 ± 0.010) × log10(speed/(1.0 mm/s)))"`` and ``"fx plus (0.30 ± 0.05 N) × …"``.

        Parameters
        ----------
        term : str
            Name of the term.
        value, half_width : float
            The coefficient and half of its 95 % interval, in the carrier's unit.
        since : Since, optional
            Given where the term is the time since the last step of a covariate: a component then creeps.
        """
        if self.shifted:
            # a contact found too early lies where the prediction bends: its slope gives only a rough size
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
    """Return the carriers of residuals: shared parameters with a known value, then every component in its unit."""
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
    """All products of c carriers and m terms; a candidate's number is ``carrier * m + term``.

    Parameters
    ----------
    carriers : tuple of Carrier
    names : tuple of str
        Name of each term.
    complexities : tuple of int
        Complexity of each term: the sum over its atoms.
    terms : (n, m)
        Value of each term in each frame, dimensionless.
    definitions : dict, term -> tuple of str
        How the atoms of a term are computed, in words.
    since : dict, term -> Since
        The covariate from whose last step a term counts the time.
    """

    carriers: tuple[Carrier, ...]
    names: tuple[str, ...]
    complexities: tuple[int, ...]
    terms: Array
    definitions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    since: Mapping[str, Since] = field(default_factory=dict)

    @classmethod
    def of(cls, carriers: Sequence[Carrier], atoms: Sequence[Atom]) -> Candidates:
        """Return the candidates made of atoms and of products of two atoms.

        A product that is constant or equals one of its factors is left out.
        """
        # the atoms themselves
        names, complexities = [atom.name for atom in atoms], [atom.complexity for atom in atoms]
        columns = [atom.values for atom in atoms]
        definitions: dict[str, tuple[str, ...]] = {atom.name: (atom.definition,) for atom in atoms}
        # products of two atoms
        for first, atom in enumerate(atoms):
            for other in atoms[first:]:
                product = atom.values * other.values
                if (
                    np.ptp(product) <= 0
                    or np.array_equal(product, atom.values)
                    or np.array_equal(product, other.values)
                ):
                    continue
                parts = (atom.definition, other.definition)
                names.append(f"{atom.name} × {other.name}" if other is not atom else f"{atom.name}^2")
                definitions[names[-1]] = tuple(dict.fromkeys(parts))
                complexities.append(atom.complexity + other.complexity)
                columns.append(product)
        # a shift alone is an explanation: it needs the constant term
        if any(carrier.shifted for carrier in carriers):
            names, complexities = [CONSTANT, *names], [0, *complexities]
            columns = [np.ones(len(carriers[0].field)), *columns]
        matrix = np.column_stack(columns) if columns else np.zeros((len(carriers[0].field), 0))
        since = {atom.name: atom.since for atom in atoms if atom.since is not None}
        return cls(tuple(carriers), tuple(names), tuple(complexities), matrix, definitions, since)

    def part(self, rows: NDArray[np.bool_]) -> Candidates:
        """Return the candidates restricted to the frames of a mask (n,)."""
        kept = tuple(
            Carrier(carrier.name, carrier.field[rows], carrier.unit, carrier.shifted, carrier.definition)
            for carrier in self.carriers
        )
        return Candidates(kept, self.names, self.complexities, self.terms[rows], self.definitions, self.since)

    def __len__(self) -> int:
        return len(self.carriers) * len(self.names)

    def carrier_of(self, number: int) -> Carrier:
        """Return the carrier of the candidate with this number."""
        return self.carriers[number // len(self.names)]

    def name_of(self, number: int) -> str:
        """Return the name of the term of the candidate with this number."""
        return self.names[number % len(self.names)]

    def definitions_of(self, numbers: Sequence[int]) -> tuple[str, ...]:
        """Return how the atoms and shifts of several candidates are computed, each definition once."""
        parts = [part for number in numbers for part in self.definitions.get(self.name_of(number), ())]
        parts += [definition for number in numbers if (definition := self.carrier_of(number).definition)]
        return tuple(dict.fromkeys(parts))

    def full_name(self, number: int) -> str:
        """Return carrier and term of the candidate with this number, as ``"E: speed/(1 mm/s)"``."""
        return f"{self.carrier_of(number).name}: {self.name_of(number)}"

    def complexity_of(self, number: int) -> int:
        """Return the complexity of the candidate with this number."""
        return self.complexities[number % len(self.names)]

    def field(self, number: int) -> Array:
        """Return the whitened field (n, k) of a candidate with coefficient 1."""
        return self.carrier_of(number).field * self.terms[:, number % len(self.names), None]

    def fields(self, numbers: Sequence[int]) -> dict[str, Array]:
        """Return the whitened fields (n, k) of several candidates by their full names."""
        return {self.full_name(number): self.field(number) for number in numbers}

    def scores(self, projection: ProjectedResiduals) -> Contributions:
        """Return the contributions of the units of exchange to the scores of all candidates."""
        by_carrier = [along(projection, carrier.field, self.terms) for carrier in self.carriers]
        return Contributions(
            np.concatenate([part.by_unit for part in by_carrier], axis=1),
            np.concatenate([part.information_by_unit for part in by_carrier], axis=1),
            joined_refits([part.refit for part in by_carrier]),
        )

    @cached_property
    def sizes(self) -> Array:
        """Squared norms (c m,) of the candidates' fields before anything is projected out."""
        squares = np.stack([np.einsum("nk,nk->n", carrier.field, carrier.field) for carrier in self.carriers])
        return (squares @ self.terms**2).ravel()
