"""Units as factors to SI and exponents of the base dimensions, so that only what has no dimension is ever fitted."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

Exponents = tuple[float, ...]

NONE: Exponents = (0.0, 0.0, 0.0, 0.0, 0.0)
"""Of length, mass, time, temperature, current."""


@dataclass(frozen=True)
class Unit:
    """A unit.

    Parameters
    ----------
    factor : float
        To SI.
    exponents : of length, mass, time, temperature, current
    """

    factor: float
    exponents: Exponents

    def power(self, exponent: float) -> Unit:
        """The unit to a power."""
        return Unit(self.factor**exponent, tuple(exponent * each for each in self.exponents))

    def times(self, other: Unit) -> Unit:
        """The product of two units."""
        both = tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True))
        return Unit(self.factor * other.factor, both)

    @property
    def is_pure(self) -> bool:
        """Whether it is a number."""
        return not any(self.exponents)


def _table() -> dict[str, Unit]:
    length, mass, time = (1, 0, 0, 0, 0), (0, 1, 0, 0, 0), (0, 0, 1, 0, 0)
    force, pressure, energy = (1, 1, -2, 0, 0), (-1, 1, -2, 0, 0), (2, 1, -2, 0, 0)
    known: dict[Exponents, dict[str, float]] = {
        length: {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9, "in": 0.0254},
        mass: {"kg": 1.0, "g": 1e-3},
        time: {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
        (0, 0, 0, 1, 0): {"K": 1.0, "degC": 1.0, "°C": 1.0, "C": 1.0},
        (0, 0, 0, 0, 1): {"A": 1.0, "mA": 1e-3},
        force: {"N": 1.0, "mN": 1e-3, "kN": 1e3},
        pressure: {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
        energy: {"J": 1.0, "mJ": 1e-3, "Nm": 1.0, "Nmm": 1e-3, "mNm": 1e-3},
        (2, 1, -3, 0, 0): {"W": 1.0},
        (2, 1, -3, 0, -1): {"V": 1.0, "mV": 1e-3},
        (0, 0, -1, 0, 0): {"Hz": 1.0, "rpm": math.pi / 30},
        NONE: {"1": 1.0, "rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "percent": 1e-2, "%": 1e-2, "ppm": 1e-6},
    }
    return {name: Unit(factor, exponents) for exponents, names in known.items() for name, factor in names.items()}


UNITS = _table()
_POWER = re.compile(r"(?P<name>[^\W\d_]+|%|1)(?:\^?(?P<power>-?\d))?")


def find_unit(text: str) -> Unit | None:
    """The unit that a text means, as ``"N/mm"``, ``"mm^2"``, ``"N m"``, ``"1/s"``; ``None`` where it means none."""
    total = Unit(1.0, NONE)
    for position, part in enumerate(text.strip().split("/")):
        words = part.replace("*", " ").split()
        if not words:
            return None
        for word in words:
            found = _POWER.fullmatch(word)
            if found is None or found["name"] not in UNITS:
                return None
            power = float(found["power"] or 1) * (1.0 if position == 0 else -1.0)
            total = total.times(UNITS[found["name"]].power(power))
    return total
