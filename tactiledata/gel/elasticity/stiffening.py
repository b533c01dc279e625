"""Terms beyond neo-Hooke: how a gel stiffens as it is strained."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactiledata.errors import UsageError


@dataclass(frozen=True)
class Stiffening:
    """Yeoh's further terms, W = C10 (I - 3) + C20 (I - 3)^2 + C30 (I - 3)^3, as ratios to C10 (O. H. Yeoh, Rubber Chem.
    Technol. 63, 1990); I is the first invariant of the isochoric deformation, J^(-2/3) I1.

    They vanish in the small-strain limit, so that E and nu keep their meaning; the linear fidelity does not see them.

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
