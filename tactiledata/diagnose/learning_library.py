"""The library that trees, boosting and Gaussian processes come from, which the base install does not have."""

from __future__ import annotations

from importlib.util import find_spec

from tactiledata.errors import TactileDataError


def need_learning_library() -> None:
    """Nothing, where it is installed.

    Raises
    ------
    TactileDataError
        It is not.
    """
    if find_spec("sklearn") is None:
        raise TactileDataError(
            "the package 'scikit-learn' is not installed", "it, for a diagnosis", "pip install 'tactiledata[models]'"
        )
