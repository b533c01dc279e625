"""Material of the gel: Young's modulus, Poisson's ratio, and the friction of its surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactiledata.errors import UsageError

LARGEST_POISSON_RATIO = 0.4999
"""Largest Poisson's ratio: above it rounding errors of the bulk modulus hide all other terms."""


@dataclass(frozen=True)
class GelMaterial:
    """A compressible neo-Hookean gel under Coulomb friction.

    The energy density is W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 (Bonet and Wood, Nonlinear Continuum Mechanics
    for Finite Element Analysis, eq. 6.27), whose small-strain limit is the linear law with the same E and nu.

    Parameters
    ----------
    youngs_modulus : Pa
        Positive.
    poisson_ratio : float
        In (-1, 0.4999].
    friction : float
        Coulomb's coefficient between indenter and gel, 0 or more.

    Raises
    ------
    UsageError
        A value outside its range.
    """

    youngs_modulus: float
    poisson_ratio: float
    friction: float

    def __post_init__(self) -> None:
        checks = (
            (
                "youngs_modulus",
                self.youngs_modulus,
                0.0 < self.youngs_modulus < math.inf,
                "a positive number, Pa: a soft gel has 1e5 to 1e6",
            ),
            (
                "poisson_ratio",
                self.poisson_ratio,
                -1.0 < self.poisson_ratio <= LARGEST_POISSON_RATIO,
                f"above -1 and at most {LARGEST_POISSON_RATIO}",
            ),
            ("friction", self.friction, 0.0 <= self.friction < math.inf, "0 or more"),
        )
        for name, value, holds, expected in checks:
            if not holds:
                raise UsageError(f"the gel's {name} is {value!r}", expected, "Correct the material.", value=value)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus (Lamé's mu), Pa."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """Lamé's first parameter lambda, Pa."""
        return (
            self.youngs_modulus * self.poisson_ratio / ((1.0 + self.poisson_ratio) * (1.0 - 2.0 * self.poisson_ratio))
        )
