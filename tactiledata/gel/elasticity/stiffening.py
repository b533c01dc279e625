"""Yeoh's terms of the energy beyond neo-Hooke, by which a gel stiffens at large strain."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactiledata.errors import UsageError


@dataclass(frozen=True)
class Stiffening:
    """Coefficients C20 and C30 of Yeoh's energy, as ratios to C10.

    W = C10 (I - 3) + C20 (I - 3)^2 + C30 (I - 3)^3, where I = J^(-2/3) I1 is the first invariant of the isochoric
    deformation (O. H. Yeoh, Rubber Chem. Technol. 63, 1990). The further terms vanish in the small-strain limit, so
    that E and nu keep their meaning; the linear fidelity ignores them.

    Parameters
    ----------
    c20, c30 : float
        Ratios to C10; 0 is neo-Hookean.

    Raises
    ------
    UsageError
        A ratio that is not a number.
    """

    c20: float = 0.0
    c30: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("c20", self.c20), ("c30", self.c30)):
            if not math.isfinite(value):
                raise UsageError(f"the gel's {name} is {value!r}", "a finite ratio to C10", "Correct the law.")
