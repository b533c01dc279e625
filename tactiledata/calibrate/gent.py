"""Young's modulus of rubber from its Shore A hardness (Gent 1958)."""

from __future__ import annotations

from tactiledata.errors import UsageError

DIGIT_SHORE_A = 24.5
"""Shore A hardness of the DIGIT's gel: the maker states 75 on the Shore 00 scale, which is 24 to 25 on Shore A."""


def youngs_modulus_of_shore_a(hardness: float) -> float:
    """Return Young's modulus, Pa, of rubber of a Shore A hardness.

    Gent, On the relation between indentation hardness and Young's modulus (1958), in the form that the SPLIT paper
    prints.

    Raises
    ------
    UsageError
        A hardness that is not on the scale, 0 to below 100.

    Examples
    --------
    >>> round(youngs_modulus_of_shore_a(24.0))
    883140
    """
    if not 0.0 <= hardness < 100.0:
        raise UsageError(f"a Shore A hardness of {hardness}", "0 to below 100", "State the durometer's reading.")
    return 1e6 * 0.0981 * (56.0 + 7.62336 * hardness) / (0.137505 * (254.0 - 2.54 * hardness))
