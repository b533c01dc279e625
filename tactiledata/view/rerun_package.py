"""Import of rerun, an optional package, at the moment when it is needed."""

from __future__ import annotations

from typing import Any

from tactiledata.errors import UsageError


def load_rerun() -> Any:
    """Return the module ``rerun``, imported now.

    Raises
    ------
    UsageError
        It is not installed.
    """
    try:
        import rerun
    except ImportError as error:
        raise UsageError(
            "the viewer needs rerun, which is not installed", "", "pip install -c constraints.txt -e '.[view]'"
        ) from error
    return rerun
