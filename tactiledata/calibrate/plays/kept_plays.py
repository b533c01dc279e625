"""Cache of simulated touches on disk: one small file for each touch, nu, mu and contact offset."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.program import statements
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.indenters.base import Indenter

SOLIDS = 32
"""Largest number of indenters whose meshes are kept as bytes."""


@dataclass(frozen=True)
class Play:
    """Simulated wrench, solver status and contact area of each of the n frames of a touch.

    Parameters
    ----------
    wrench : (n, 6) m^2, m^3
        Contact wrench over Young's modulus, gel frame; NaN where a frame could not be solved.
    status : (n,) int8
        Values of ``FrameStatus``.
    area : (n,) m^2
        Area of the pressed surface patches; 0 where none is pressed.
    """

    wrench: Array
    status: NDArray[np.int8]
    area: Array


def play_path(touch: GelTouch, mesh_digest: str, mechanics: str, ratio: float, friction: float) -> Path:
    """Return the file of the cache in which a play is kept; its name is a hash of all that the play depends on.

    That is all parameters below and the program of ``gel`` and ``indenters``, without its comments and docstrings.
    Young's modulus is not part of it: wrenches are kept over Young's modulus. A contact offset or a shift along the gel
    changes the poses.

    Parameters
    ----------
    touch : GelTouch
        Poses and indenter.
    mesh_digest : str
        Digest of the pad's mesh.
    mechanics : str
        Engine and fidelity.
    ratio, friction : float
        Poisson's ratio and coefficient of friction of the gel.
    """
    digest = hashlib.sha256()
    settings = [mesh_digest, mechanics, repr(ratio), repr(friction), _engine_digest(), touch.indenter.document]
    digest.update(json.dumps(settings, sort_keys=True).encode())
    digest.update(_bytes_of(touch.poses) + _solid(touch.indenter))
    key = digest.hexdigest()
    return cache_folder() / "calibrate" / key[:2] / f"{key}.npz"


def load_play(path: Path) -> Play | None:
    """Read a play from the cache, or return ``None`` where the file is missing or damaged."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as arrays:
            play = Play(arrays["wrench"], arrays["status"], arrays["area"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    frames = len(play.status)
    return play if play.wrench.shape == (frames, 6) and play.area.shape == (frames,) else None


def keep_play(path: Path, play: Play) -> None:
    """Write a play to the cache atomically.

    A folder that cannot be written is no error: the next run only has to simulate the touch again.
    """
    content = io.BytesIO()
    np.savez(content, wrench=play.wrench, status=play.status, area=play.area)
    with contextlib.suppress(OSError):
        write_atomic(path, content.getvalue(), synced=False)


@lru_cache(SOLIDS)
def _solid(indenter: Indenter) -> bytes:
    """Vertices and faces of an indenter as bytes: hundreds of plays share an indenter, and its mesh takes time."""
    solid = indenter.mesh()
    return _bytes_of(np.asarray(solid.vertices)) + _bytes_of(np.asarray(solid.faces))


def _bytes_of(numbers: NDArray[np.generic]) -> bytes:
    """Shape and content of an array as bytes."""
    return str(numbers.shape).encode() + np.ascontiguousarray(numbers).tobytes()


@cache
def _engine_digest() -> str:
    """Hash of the program on which a play depends: of its statements, without comments and docstrings."""
    digest = hashlib.sha256()
    for package in ("tactiledata.gel", "tactiledata.indenters"):
        folder = Path(str(resources.files(package)))
        for source in sorted(folder.rglob("*.py")):
            digest.update(source.relative_to(folder).as_posix().encode() + statements(source.read_text("utf-8")))
    return digest.hexdigest()
