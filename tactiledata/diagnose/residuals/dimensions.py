"""Units as a factor to SI and exponents of base dimensions, so that fitted terms can be made dimensionless."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

Exponents = tuple[float, ...]
"""Powers of length, mass, time, temperature, current, pixels and counts of a converter, in this order."""

NONE: Exponents = (0.0,) * 7
"""The exponents of a pure number."""


@dataclass(frozen=True)
class Unit:
    """A unit of measurement, as its size in SI units and its dimension.

    Parameters
    ----------
    factor : float
        Value of one unit in SI units.
    exponents : tuple of 7 floats
        Powers of length, mass, time, temperature, current, pixels and counts of a converter.
    """

    factor: float
    exponents: Exponents

    def power(self, exponent: float) -> Unit:
        """Return the unit raised to an exponent."""
        return Unit(self.factor**exponent, tuple(exponent * own for own in self.exponents))

    def times(self, other: Unit) -> Unit:
        """Return the product of this unit and another one."""
        both = tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True))
        return Unit(self.factor * other.factor, both)

    @property
    def is_pure(self) -> bool:
        """Whether the unit has no dimension."""
        return not any(self.exponents)


PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "n": 1e-9, "p": 1e-12}
"""Factor of each prefix."""
BASE: dict[tuple[int, ...], dict[str, float]] = {
    (1, 0, 0, 0, 0, 0, 0): {"m": 1.0},
    (0, 1, 0, 0, 0, 0, 0): {"g": 1e-3},
    (0, 0, 1, 0, 0, 0, 0): {"s": 1.0},
    (0, 0, 0, 1, 0, 0, 0): {"K": 1.0},
    (0, 0, 0, 0, 1, 0, 0): {"A": 1.0},
    (1, 1, -2, 0, 0, 0, 0): {"N": 1.0},
    (-1, 1, -2, 0, 0, 0, 0): {"Pa": 1.0, "bar": 1e5},
    (2, 1, -2, 0, 0, 0, 0): {"J": 1.0, "Nm": 1.0},
    (2, 1, -3, 0, 0, 0, 0): {"W": 1.0},
    (2, 1, -3, 0, -1, 0, 0): {"V": 1.0},
    (2, 1, -3, 0, -2, 0, 0): {"ohm": 1.0, "Ohm": 1.0},
    (0, 1, -2, 0, -1, 0, 0): {"T": 1.0},
    (0, 0, -1, 0, 0, 0, 0): {"Hz": 1.0},
    (0, 0, 0, 0, 0, 0, 0): {"rad": 1.0},
}
"""Units that take a prefix: exponents -> name -> factor to SI."""
PLAIN: dict[tuple[int, ...], dict[str, float]] = {
    (1, 0, 0, 0, 0, 0, 0): {"cm": 1e-2, "in": 0.0254},
    (0, 0, 1, 0, 0, 0, 0): {"min": 60.0, "h": 3600.0},
    (0, 0, 0, 1, 0, 0, 0): {"degC": 1.0, "°C": 1.0, "C": 1.0},
    (-1, 1, -2, 0, 0, 0, 0): {"hPa": 1e2, "psi": 6894.757},
    (2, 1, -2, 0, 0, 0, 0): {"Nmm": 1e-3},
    (-2, -1, 4, 0, 2, 0, 0): {"pF": 1e-12, "nF": 1e-9, "uF": 1e-6, "µF": 1e-6},
    (0, 0, -1, 0, 0, 0, 0): {"rpm": math.pi / 30},
    (0, 0, 0, 0, 0, 1, 0): {"px": 1.0, "pixels": 1.0},
    (0, 0, 0, 0, 0, 0, 1): {"counts": 1.0},
    (0, 0, 0, 0, 0, 0, 0): {"1": 1.0, "deg": math.pi / 180, "percent": 1e-2, "pct": 1e-2, "%": 1e-2, "ppm": 1e-6},
}
"""Units that take no prefix: exponents -> name -> factor to SI."""


def _table() -> dict[str, Unit]:
    """Return every known unit by its text, with and without prefixes."""
    known = {
        f"{prefix}{name}": Unit(size * factor, tuple(map(float, exponents)))
        for exponents, names in BASE.items()
        for name, factor in names.items()
        for prefix, size in {"": 1.0, **PREFIXES}.items()
    }
    plain = {
        name: Unit(factor, tuple(map(float, exponents)))
        for exponents, names in PLAIN.items()
        for name, factor in names.items()
    }
    return known | plain


UNITS = _table()
"""Every known unit by its text, such as ``"mm"`` or ``"degC"``."""
_POWER = re.compile(r"(?P<name>[^\W\d_]+|%|1)(?:\^?(?P<power>-?\d))?")


def find_unit(text: str) -> Unit | None:
    """Return the unit that a text such as ``"N/mm"``, ``"mm^2"`` or ``"N m"`` means; ``None`` where it means none."""
    total = Unit(1.0, NONE)
    for position, part in enumerate(text.strip().split("/")):
        words = part.replace("*", " ").split()
        if not words:
            return None
        for word in words:
            match = _POWER.fullmatch(word)
            if match is None or match["name"] not in UNITS:
                return None
            power = float(match["power"] or 1) * (1.0 if position == 0 else -1.0)
            total = total.times(UNITS[match["name"]].power(power))
    return total
