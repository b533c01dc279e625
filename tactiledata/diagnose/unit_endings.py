"""Units at the end of a column's name: ``"speed_mm_per_s"`` is speed in mm/s."""

from __future__ import annotations

from collections.abc import Sequence

from tactiledata.diagnose.dimensions import find_unit

FORCES, LENGTHS = ("N", "mN", "uN", "kN"), ("m", "mm", "cm", "um")
"""Side by side they are a torque."""


def split_unit(column: str) -> tuple[str, str]:
    """Name and unit of a column: ``"depth_mm"`` is depth in mm, ``"speed_mm_s"`` and ``"speed_mm_per_s"`` are in mm/s.

    What follows ``per`` divides: ``"rate_per_s"`` is in 1/s, ``"k_N_m_per_rad"`` in N m/rad. Without ``per`` the second
    of two units side by side divides, but in ``N_m`` and ``N_mm``. An ending that is no unit belongs to the name, and
    the unit is ``"?"``.
    """
    parts = column.split("_")
    for position in range(1, len(parts)):
        unit = _chained(parts[position:])
        if unit is not None and find_unit(unit) is not None:
            return "_".join(parts[:position]), unit
    return column, "?"


def _chained(words: Sequence[str]) -> str | None:
    """The unit that words side by side mean, as ``"N m/rad"``; ``None`` where they mean none."""
    if "deg" in words[:-1] and words[words.index("deg") + 1] == "C":
        place = words.index("deg")
        words = [*words[:place], "degC", *words[place + 2 :]]
    if words[-1] == "per" or any(word[:1].isdigit() or not word for word in words):
        return None
    chained, divides, before = "", False, ""
    for word in words:
        if word == "per":
            divides, chained = True, chained or "1"
            continue
        is_product = not divides and (not before or _is_product(before, word, "per" in words))
        chained += word if not chained else f" {word}" if is_product else f"/{word}"
        before = word
    return chained


def _is_product(before: str, word: str, is_per: bool) -> bool:
    """Whether a unit beside another one multiplies it: before ``per``, with its own sign, or a force's length."""
    return is_per or "-" in word or (before in FORCES and word in LENGTHS)
