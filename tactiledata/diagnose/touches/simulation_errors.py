"""Errors of simulated wrenches by mesh, contact and solver: a few directions, with unknown sizes, for each indenter.

Two solvers of one gel differ by some per cent. The difference is smooth along a touch, differs from indenter to
indenter, and repeats in every touch of one indenter, so that more touches do not average it away. Here it is a sum of
a few directions for each indenter, each with a normal prior: factors on the force that grow with it, on shear that
sticks and that slides, on what a tilted indenter is pushed aside, and motions of the centre of pressure. A fit
determines their sizes with everything else.

Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001), with a basis in place of a Gaussian process.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tactiledata.nuisance.numerical import LAW_ERROR, SHAPE_ERROR

NORMAL, SHEAR, CENTRE = "normal force", "shear", "centre of pressure"
"""Families of errors, each with a size of its own."""
FAMILIES = (NORMAL, SHEAR, CENTRE)


@dataclass(frozen=True)
class NumericalErrors:
    """Standard deviations of the errors of a simulation.

    Parameters
    ----------
    shape : float
        Of a factor on all forces of one indenter, about 1.
    law : float
        Of the growth of force: a share over a factor e of the force, common to all indenters and of each of them.
    shear : float
        Of a factor on shear that sticks, about 1, common to all indenters and of each of them.
    scatter : float
        Of each frame by itself, as a share of its force.
    centre : float
        Of the centre of pressure, in metres, under one indenter and of each frame by itself.
    sizes : dict, (family, indenter) -> float
        Factor on the errors of a family under an indenter, as estimated from the data at hand; the indenter is empty
        for errors that all have in common. It is 1 where nothing is known.
    """

    shape: float = SHAPE_ERROR["finite-strain"]
    law: float = 0.03
    shear: float = 0.04
    scatter: float = 0.007
    centre: float = 4e-5
    sizes: Mapping[tuple[str, str], float] | None = None

    @staticmethod
    def of(mechanics: str) -> NumericalErrors:
        """Return the errors of a kind of mechanics: a key of ``SHAPE_ERROR``, as "finite-strain" or "linear"."""
        law = 0.03 * (LAW_ERROR[mechanics] / LAW_ERROR["finite-strain"])
        return NumericalErrors(shape=SHAPE_ERROR[mechanics], law=law)

    def with_sizes(self, sizes: Mapping[tuple[str, str], float]) -> NumericalErrors:
        """Return the same errors with other factors, for each family and indenter."""
        return replace(self, sizes=dict(sizes))

    def size(self, family: str, indenter: str = "") -> float:
        """Return the factor on the errors of a family under an indenter, or on those that all have in common."""
        return 1.0 if self.sizes is None else self.sizes.get((family, indenter), 1.0)


@dataclass(frozen=True)
class ErrorDirection:
    """One direction in which the simulation may err.

    Parameters
    ----------
    what : str
        The error in words, without the indenter.
    family : str
        One of ``FAMILIES``.
    deviation : float
        Standard deviation, a share of the force, or metres.
    indenter : str
        Indenter whose simulation errs; empty where the error is common to all.
    """

    what: str
    family: str
    deviation: float
    indenter: str = ""

    @property
    def label(self) -> str:
        """The error in words, with the indenter."""
        return f"{self.what} of {self.indenter}" if self.indenter else self.what


@dataclass(frozen=True)
class ErrorKind:
    """One kind of error of a simulation; its standard deviation is a multiple of one of `NumericalErrors`.

    Parameters
    ----------
    what : str
        The error in words, without the indenter.
    family : str
        One of ``FAMILIES``.
    of : str
        Name of the field of `NumericalErrors`.
    times : float
        Factor on it.
    is_common : bool
        Whether all indenters have such an error in common, beside that of each of them.
    """

    what: str
    family: str
    of: str
    times: float = 1.0
    is_common: bool = False


KINDS = (
    ErrorKind("all forces", NORMAL, "shape"),
    ErrorKind("the growth of force with depth", NORMAL, "law", is_common=True),
    ErrorKind("the curve of force over depth", NORMAL, "law", 0.5),
    ErrorKind("force while it is taken off", NORMAL, "law", 0.5),
    ErrorKind("normal force under shear", NORMAL, "law", 0.5),
    ErrorKind("shear that sticks", SHEAR, "shear", is_common=True),
    ErrorKind("the growth of shear with depth", SHEAR, "shear", 0.5),
    ErrorKind("shear that begins to slide", SHEAR, "shear"),
    ErrorKind("shear that sticks while the force is taken off", SHEAR, "shear", 0.5),
    ErrorKind("shear after a turn", SHEAR, "shear"),
    ErrorKind("shear that slides", SHEAR, "shear", 0.5),
    ErrorKind("the growth of sliding shear with depth", SHEAR, "shear", 0.5),
    ErrorKind("sliding shear while the force is taken off", SHEAR, "shear", 0.5),
    ErrorKind("shear along the indenter's x against its y", SHEAR, "shear", 0.5),
    ErrorKind("the push aside by a tilt", SHEAR, "shear", 4.0),
    ErrorKind("the centre of pressure along the indenter's x", CENTRE, "centre"),
    ErrorKind("the centre of pressure along the indenter's y", CENTRE, "centre"),
    ErrorKind("the centre of pressure under a tilt", CENTRE, "centre", 20.0),
)
"""Kinds of errors, in the order of the fields."""


def error_list(errors: NumericalErrors, names: Sequence[str]) -> tuple[ErrorDirection, ...]:
    """Return the directions in which a simulation may err: those of each indenter, then those of all together.

    Parameters
    ----------
    errors : NumericalErrors
        Sizes.
    names : sequence of str
        Names of the indenters.
    """

    def error(kind: ErrorKind, name: str) -> ErrorDirection:
        deviation = kind.times * getattr(errors, kind.of) * errors.size(kind.family, name)
        return ErrorDirection(kind.what, kind.family, deviation, name)

    of_each = [error(kind, name) for name in names for kind in KINDS]
    return (*of_each, *(error(kind, "") for kind in KINDS if kind.is_common))
