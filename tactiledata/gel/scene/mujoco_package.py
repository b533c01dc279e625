"""MuJoCo, imported when it is needed: an optional package."""

from __future__ import annotations

import os
import sys
from typing import Any

from tactiledata.errors import UsageError


def load_mujoco(what: str) -> Any:
    """The package, able to draw also where there is no window system.

    Parameters
    ----------
    what : str
        What needs it, in words.

    Raises
    ------
    UsageError
        It is not installed.
    """
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        # read when mujoco is first imported; without a window system only EGL or OSMesa can draw
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        import mujoco
    except ImportError as error:
        raise UsageError(
            f"{what} needs MuJoCo, which is not installed", "", "pip install -c constraints.txt -e '.[sim]'"
        ) from error
    return mujoco
