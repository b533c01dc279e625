"""Import of rerun, an optional package, at the moment when it is needed."""

from __future__ import annotations

from typing import Any

from tactiledata.contract.extras import missing_package


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
        raise missing_package("rerun", "the viewer") from error
    return rerun
