"""Plays that are kept on disk: one small file for each touch, nu, mu and offset."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.contract.atomic import write_atomic
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.compliance import cache_folder


@dataclass(frozen=True)
class Play:
    """What the gel answered to a touch.

    Parameters
    ----------
    wrench : (n, 6) m^2, m^3
        Over Young's modulus; NaN where a frame could not be solved.
    status : (n,) int8, of ``FrameStatus``
    area : (n,) m^2
        Of the patches that are pressed; 0 where none is.
    """

    wrench: Array
    status: NDArray[np.int8]
    area: Array


def play_path(touch: GelTouch, mesh_digest: str, mechanics: str, ratio: float, friction: float) -> Path:
    """Where a play is kept; another pose, indenter, mesh, material or engine has another place."""
    whole = hashlib.sha256()
    settings = [mesh_digest, mechanics, repr(ratio), repr(friction), _engine_digest(), touch.indenter.document]
    whole.update(json.dumps(settings, sort_keys=True).encode())
    solid = touch.indenter.mesh()
    for part in (touch.poses, np.asarray(solid.vertices), np.asarray(solid.faces)):
        whole.update(str(part.shape).encode() + np.ascontiguousarray(part).tobytes())
    key = whole.hexdigest()
    return cache_folder() / "calibrate" / key[:2] / f"{key}.npz"


def load_play(path: Path) -> Play | None:
    """The play, or ``None`` where there is none that can be read."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as kept:
            play = Play(kept["wrench"], kept["status"], kept["area"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    frames = len(play.status)
    return play if play.wrench.shape == (frames, 6) and play.area.shape == (frames,) else None


def keep_play(path: Path, play: Play) -> None:
    """Write it, whole or not at all; a folder that cannot be written costs time at the next run, nothing else."""
    content = io.BytesIO()
    np.savez(content, wrench=play.wrench, status=play.status, area=play.area)
    with contextlib.suppress(OSError):
        write_atomic(path, content.getvalue())


@cache
def _engine_digest() -> str:
    """Of the programs that a play depends on."""
    whole = hashlib.sha256()
    for package in ("tactiledata.gel", "tactiledata.indenters"):
        folder = Path(str(resources.files(package)))
        for source in sorted(folder.rglob("*.py")):
            whole.update(source.relative_to(folder).as_posix().encode() + source.read_bytes())
    return whole.hexdigest()
