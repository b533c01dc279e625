"""Import of MuJoCo, an optional package, at the moment when it is needed."""

from __future__ import annotations

import os
import sys
from typing import Any

from tactiledata.contract.extras import missing_package


def load_mujoco(what: str) -> Any:
    """Return the module ``mujoco``, imported now and set up to draw also where there is no window system.

    On Linux without ``DISPLAY`` it sets the environment variable ``MUJOCO_GL`` to ``egl`` unless it is set; that has no
    effect where MuJoCo was imported before.

    Parameters
    ----------
    what : str
        What needs MuJoCo: the subject of the message's sentence, such as ``"the scene"``.

    Raises
    ------
    UsageError
        MuJoCo cannot be imported.
    """
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        # read when mujoco is first imported; without a window system only EGL or OSMesa can draw
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        import mujoco
    except ImportError as error:
        raise missing_package("mujoco", what) from error
    return mujoco
